"""What a scene says of itself, kept short: names, sentences of its report, and what can be chosen.

All of it goes to whoever looks at the scene, and a file may bring names of megabytes and a million of them.
"""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from typing import TypeVar

from gpu.errors import brief
from gpu.scene.types import Camera, Light, Material, Scene, Texture

MOST_NAME = 200  # characters: more than any name that fits into a list on a screen
MOST_SENTENCE = 500  # characters
MOST_SENTENCES = 100  # of each kind; readers merge those that are alike
MOST_CHOICES = 256  # that are offered, as many as can be chosen at a time
MOST_CHOICE = 256  # characters, as many as the option takes
Named = TypeVar("Named", Camera, Light, Material, Texture)


def shortened(scene: Scene) -> Scene:
    """The scene with names and sentences cut, where they are too long, and ended by "…".

    Of too many sentences the first are kept, and the last says how many more there were. Choices whose name could not
    be told unchanged are not offered, and a note says so.
    """
    choices = {kind: _choosable(offered) for kind, offered in scene.choices.items()}
    notes = (*scene.report.notes, *_left_out(scene.choices, choices))
    report = replace(scene.report, ignored=_sentences(scene.report.ignored), notes=_sentences(notes))
    return replace(
        scene,
        cameras=_named(scene.cameras),
        lights=_named(scene.lights),
        materials=_named(scene.materials),
        textures=_named(scene.textures),
        choices=choices,
        report=report,
    )


def _named(things: Sequence[Named]) -> tuple[Named, ...]:
    names = (brief(thing.name, MOST_NAME) for thing in things)
    return tuple(
        thing if name == thing.name else replace(thing, name=name) for thing, name in zip(things, names, strict=True)
    )


def _sentences(said: Sequence[str]) -> tuple[str, ...]:
    kept = [brief(sentence, MOST_SENTENCE) for sentence in said[:MOST_SENTENCES]]
    return (*kept, f"{len(said) - len(kept)} more like these") if len(said) > len(kept) else tuple(kept)


def _choosable(offered: Iterable[str]) -> tuple[str, ...]:
    return tuple(name for name in offered if name and brief(name, MOST_CHOICE) == name)[:MOST_CHOICES]


def _left_out(offered: Mapping[str, Sequence[str]], kept: Mapping[str, Sequence[str]]) -> list[str]:
    fewer = {kind: len(offered[kind]) - len(kept[kind]) for kind in offered}
    return [
        f"{count} of {len(offered[kind])} choices of a {kind} are not listed: at most {MOST_CHOICES} are, with names "
        f"of 1 to {MOST_CHOICE} characters that can be printed"
        for kind, count in fewer.items()
        if count
    ]
