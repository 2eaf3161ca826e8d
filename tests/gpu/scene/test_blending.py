"""Which see-through materials are told of, since most methods show nothing of them."""

from dataclasses import replace

import pytest
from scenes import quad

from gpu.scene.assemble import assemble
from gpu.scene.blending import blending_notes
from gpu.scene.scene_parts import SceneParts
from gpu.scene.types import AlphaMode, Material

PANE = Material("pane", (0.6, 0.8, 0.9, 0.2), alpha_mode=AlphaMode.BLEND)
SAID = "is more than half see-through (alpha): --method path shows it, others show nothing there"


def test_faint_panes_are_told_of_once() -> None:
    others = [replace(PANE, name=name) for name in ("door", "lid")]
    assert blending_notes([PANE, *others]) == (f"pane: {SAID} (likewise door, lid)",)


@pytest.mark.parametrize(
    "shown",
    [
        replace(PANE, alpha_mode=AlphaMode.OPAQUE),
        replace(PANE, alpha_mode=AlphaMode.MASK, alpha_cutoff=0.1),
        replace(PANE, base_color=(0.6, 0.8, 0.9, 0.5)),
    ],
)
def test_what_all_methods_show_is_not(shown: Material) -> None:
    assert blending_notes([shown]) == ()


@pytest.mark.parametrize(("material", "told"), [(0, True), (1, False)])
def test_only_materials_of_surfaces_count(material: int, told: bool) -> None:
    wall = quad([0, 0, 0], [1, 0, 0], [0, 1, 0], material)
    scene = assemble("house", SceneParts([wall], [PANE, Material("wall")]))
    assert (f"pane: {SAID}" in scene.report.notes) == told
