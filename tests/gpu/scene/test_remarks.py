from gpu.scene.remarks import Remarks


def test_what_is_said_twice_of_a_place_is_said_once() -> None:
    remarks = Remarks()
    for _ in range(2):
        remarks.add("points have no surface")
        remarks.add("is missing", "images[0]")
    assert remarks.sentences() == ("points have no surface", "images[0]: is missing")


def test_problems_of_a_kind_become_one_sentence() -> None:
    remarks = Remarks()
    for number in range(10_000):
        remarks.add(f"is {number + 2}; 1 was used", f"materials[{number}]", kind="roughness")
    remarks.add("other")
    first, other = remarks.sentences()
    named = ", ".join(f"materials[{number}]" for number in range(1, 7))
    assert first == f"materials[0]: is 2; 1 was used (likewise {named} and 9993 more)"
    assert other == "other"


def test_what_is_counted_is_said_where_there_is_any() -> None:
    remarks = Remarks()
    remarks.add_count("corners that are broken", 1234)
    remarks.add_count("none", 0)
    assert remarks.sentences() == ("corners that are broken (1,234)",)
