"""The light that light paths are drawn by (gpu.scene.lighting.path_light), on a device, in arrays that stay."""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
import warp as wp

from gpu.core.device import duplicate, overwrite
from gpu.device_scene.data import SceneData
from gpu.device_scene.upload import DeviceScene
from gpu.lights.build import build_light_table, power_cdf, probabilities
from gpu.lights.light_table import DIRECTIONAL, LightTable, PowerCdf
from gpu.lights.sun_map import SunMaps
from gpu.scene.lighting.path_light import path_light, path_light_shares
from gpu.scene.types import Doubles, Ints, Mask, Scene, same_sky

# Of all paths, those that begin at suns which light nothing that cameras find, where there are other emitters.
_UNSEEN_SHARE = 0.2
# Of all choices, those by power alone, where others follow what arrives.
_POWER_SHARE = 0.3
_SURFACES = "vertices", "normals", "triangles", "triangle_material", "uvs", "colors"


def same_surfaces(one: Scene, other: Scene) -> bool:
    """Whether two states of a scene have the same surfaces, whatever these emit."""
    if any(getattr(one, name) is not getattr(other, name) for name in _SURFACES):
        return False
    pairs = zip(one.materials, other.materials, strict=True)
    return all(a is b or replace(a, emission=b.emission) == b for a, b in pairs)


def _same_paths(one: Scene, other: Scene) -> bool:
    """Whether light paths of both scenes, as they are drawn, are the same: nothing differs that they meet."""
    if any(getattr(one, name) is not getattr(other, name) for name in _SURFACES):
        return False
    return same_sky(one.sky, other.sky) and one.materials == other.materials and one.lights == other.lights


def unseen_suns(table: LightTable) -> Mask:
    """Which emitters (emitter,) are suns whose maps show that cameras find nothing which they light."""
    unseen, first = np.zeros(table.count, bool), table.triangle_count + table.sky_count
    if table.suns.cumulative.shape[0] == 0:  # nothing is to be fetched while lights are edited
        return unseen
    lit = table.suns.cumulative.numpy()[:, -1] > 0.0
    unseen[first : first + len(lit)] = ~lit & (table.lights.numpy()["kind"][: len(lit)] == DIRECTIONAL)
    return unseen


def kinds_of(table: LightTable) -> Ints:
    """Which emitters (emitter,) are triangles (0), the sky (1) or punctual lights (2)."""
    return np.repeat(np.arange(3, dtype=np.int32), [table.triangle_count, table.sky_count, table.light_count])


def by_reach(table: LightTable, reach: Doubles | None) -> LightTable:
    """`table`, whose emitters are chosen by power, with choices of its own by what can reach what is seen, too.

    reach (kind,): of gpu.vpl.light_reach. Where the map of a sun shows that cameras find nothing which it lights, as
    from a closed room, it is seldom chosen. By its power it would always be.
    """
    made, device = duplicate(LightTable, table), table.all_emitters.cumulative.device
    chosen, unseen = _own(table.all_emitters), unseen_suns(table)
    made.sampled = _own(table.sampled)
    if reach is not None or unseen.any():
        shares = probabilities(table.all_emitters)
        if reach is not None:
            shares = _shares_by_reach(shares, reach[kinds_of(table)])
            if table.sampled.count > 0:
                made.sampled = power_cdf(shares[: table.sampled.count], device)
        others, hidden = shares[~unseen].sum(), shares[unseen].sum()
        if others > 0.0 and hidden > _UNSEEN_SHARE:
            shares = np.where(unseen, shares * (_UNSEEN_SHARE / hidden), shares * ((1.0 - _UNSEEN_SHARE) / others))
        chosen = power_cdf(shares, device)
    made.all_emitters = chosen
    if made.enumerated_count == 0:
        made.sampled = made.all_emitters
    return made


def _own(cdf: PowerCdf) -> PowerCdf:
    """The same choice in an array of its own, which may be overwritten."""
    own = duplicate(PowerCdf, cdf)
    own.cumulative = wp.clone(cdf.cumulative)
    return own


def _shares_by_reach(power: Doubles, reach: Doubles) -> Doubles:
    """How often each emitter is chosen by `power` and by what of it arrives, (emitter,) each."""
    arriving = power * reach
    if arriving.sum() == 0.0:
        return power
    return np.asarray(_POWER_SHARE * power / power.sum() + (1.0 - _POWER_SHARE) * arriving / arriving.sum())


# What of each kind of emitters arrives where it is seen (gpu.vpl.light_reach), as for `by_reach`.
ReachOf = Callable[[DeviceScene, LightTable], Doubles | None]


@dataclass(frozen=True)
class DrawnLight:
    """A state of a scene as light paths are drawn by it: its emitters by power, and what of those arrives."""

    device_scene: DeviceScene
    by_power: LightTable
    reach: Doubles | None


class PathLight:
    """What paths begin at: `table`; reach (kind,): as for `by_reach`; shares (light,): what each light is of that, as
    gpu.scene.lighting.path_light numbers the parts of a scene.
    """

    def __init__(self, device_scene: DeviceScene, suns: SunMaps, reach_of: ReachOf) -> None:
        """suns: the maps of the scene's suns."""
        drawn = device_scene.edited(path_light(device_scene.scene))
        table = build_light_table(drawn)
        table.suns = suns
        self._reach_of, self.reach = reach_of, reach_of(drawn, table)
        self._scene, self.table = drawn.scene, by_reach(table, self.reach)
        self._materials, self._sky = drawn.data.materials, drawn.data.sky
        self._shares = path_light_shares(device_scene.scene)
        self.shares = wp.array(self._shares, dtype=wp.vec3, device=device_scene.device)

    def seen_by_paths(self, view: SceneData) -> SceneData:
        """A view of the scene in whose place paths are traced: what emits in it, emits what they are drawn by."""
        seen = duplicate(SceneData, view)
        seen.materials, seen.sky = self._materials, self._sky
        return seen

    def of(self, edited: DeviceScene, by_power: LightTable, *, same_suns: bool) -> DrawnLight | None:
        """What paths are drawn by in `edited`, which has as much of everything, and these emitters; None where paths
        are the same as they are. same_suns: the suns' maps are.
        """
        scene = path_light(edited.scene)
        if same_suns and _same_paths(self._scene, scene):
            return None
        drawn, table = edited, by_power
        if scene is not edited.scene:
            drawn = edited.edited(scene)
            table = build_light_table(drawn)
            table.suns = by_power.suns
        return DrawnLight(drawn, table, self._reach_of(drawn, table))

    def become(self, scene: Scene, drawn: DrawnLight | None) -> None:
        """Become the light of `scene`; drawn: what `of` has told of it."""
        shares = path_light_shares(scene)
        if not np.array_equal(shares, self._shares):
            self._shares = shares
            self.shares.assign(shares)
        if drawn is None:
            return
        state = drawn.device_scene
        if state.scene.materials is not self._scene.materials:
            wp.copy(self._materials, state.data.materials)
        if state.scene.sky is not self._scene.sky:
            wp.copy(self._sky, state.data.sky)
        overwrite(LightTable, self.table, by_reach(drawn.by_power, drawn.reach))
        self._scene, self.reach = state.scene, drawn.reach
