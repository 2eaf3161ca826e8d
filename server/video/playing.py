"""What time it is in a scene's animation while a film runs."""

from collections.abc import Mapping
from math import fmod

from gpu.scene.edits import SceneEdits
from server.video.film_settings import Play


def played(edits: SceneEdits, lengths: Mapping[str, float], play: Play, time: float) -> SceneEdits:
    """`edits` of a scene as they are `time` seconds after a film's beginning, which shows the moment that they say.

    lengths: how long each animation of the scene lasts [s], by id; one without any, or without that of the edits,
    stays as it is.
    """
    if not lengths or play is Play.NONE or (edits.animation is not None and edits.animation not in lengths):
        return edits
    seconds = lengths[edits.animation] if edits.animation is not None else next(iter(lengths.values()))
    now = (edits.time or 0.0) + time
    if play is Play.LOOP and seconds > 0.0:
        now = fmod(now, seconds)
    return edits.model_copy(update={"time": min(now, seconds)})
