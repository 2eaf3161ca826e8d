from gpu.scene.computable import computable
from gpu.scene.scene_parts import SceneParts
from gpu.scene.types import Light, LightKind, Material


def test_numbers_that_single_precision_does_not_hold_are_bounded_and_said() -> None:
    sun = Light("sun", LightKind.DIRECTIONAL, (1.0, 1e60, 1.0))
    lamp = Material(emission=(1e300, 2.0, 0.0), ior=1e39)
    found = computable(
        SceneParts((), [Material(), lamp, Material(emission=(1e31, 0.0, 0.0))], lights=[sun], notes=["a"])
    )
    assert [material.emission for material in found.materials] == [(0.0, 0.0, 0.0), (1e30, 2.0, 0.0), (1e30, 0.0, 0.0)]
    assert found.materials[1].ior == 1e6
    assert found.lights[0].intensity == (1.0, 1e30, 1.0)
    assert found.notes == (
        "a",
        "materials[1].emission: is more than can be computed with; 1e+30 was taken "
        "(likewise materials[2].emission, lights[0].intensity)",
        "materials[1].ior: is more than can be computed with; 1e+06 was taken",
    )


def test_what_can_be_computed_with_stays_as_it_is() -> None:
    found = SceneParts(
        (), [Material(emission=(1e30, 0.0, 0.0))], lights=[Light("bulb", LightKind.POINT, (1e30, 1.0, 1.0))]
    )
    assert computable(found) is found
