import warp as wp

from gpu.indirect.irradiance import CHECKS, NEAR_PARTS, Indirect, allocate_indirect


def test_there_is_room_for_all_checks_and_parts_of_each_pixel() -> None:
    indirect = allocate_indirect(12, wp.get_device("cpu"))
    assert indirect.target.shape == (CHECKS, 12)
    assert indirect.unoccluded_prefix.shape == (NEAR_PARTS, 12)
    rest = set(Indirect.vars) - {"target", "unoccluded_prefix"}
    assert {getattr(indirect, name).shape for name in rest} == {(12,)}
