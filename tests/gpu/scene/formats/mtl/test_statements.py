"""Statements of MTL libraries: values of keywords in any order and case, and options of maps."""

import pytest

from gpu.scene.formats.mtl.statements import MapStatement, MtlMaterial, read_materials
from gpu.scene.remarks import Remarks


def one(lines: str, remarks: Remarks) -> MtlMaterial:
    (material,) = read_materials("a.mtl", f"newmtl one\n{lines}\n", remarks)
    return material


def test_keywords_in_any_case_and_white_space() -> None:
    found = read_materials("a.mtl", "newmtl\ta  b\n\tKD\t0.5 0.5 0.5\nNEWMTL c\nns 3 # dull\n", Remarks())
    assert [material.name for material in found] == ["a b", "c"]
    assert (found[0].color("kd", (0, 0, 0)), found[1].scalar("ns", 0.0)) == ((0.5, 0.5, 0.5), 3.0)
    assert (found[0].scalar("ns", 7.0), found[0].map("map_kd")) == (7.0, None)


@pytest.mark.parametrize(
    ("value", "expected"),
    [
        ("my wall.png", MapStatement("my wall.png")),
        ("-s 2 my wall.png", MapStatement("my wall.png", scale=(2.0, 1.0))),
        ("-s 2 3 -o 0.5 0.25 1 -bm 0.5 5.png", MapStatement("5.png", (2.0, 3.0), (0.5, 0.25), bump=0.5)),
        ("-s 1 1 1 1", MapStatement("1")),
        ("-clamp on -blendu off a.png", MapStatement("a.png", clamp=True)),
        ("-CLAMP off\ta.png", MapStatement("a.png")),
        ("-mm 0 1 -imfchan r -type sphere a.png", MapStatement("a.png")),
        ("-odd name.png", MapStatement("-odd name.png")),
    ],
)
def test_options_of_maps(value: str, expected: MapStatement) -> None:
    assert one(f"map_Kd {value}", Remarks()).map("map_kd") == expected


def test_options_without_effect_are_said() -> None:
    remarks = Remarks()
    one("bump -mm 0 1 -bm 2 a.png", remarks).map("bump")
    assert remarks.sentences() == ("a.mtl: line 2: option -mm of MTL maps is not supported and was ignored",)
