from pathlib import Path

import pytest
from dae_file import TEXTURE, dae, effect

from gpu.scene.formats.collada.document import open_document
from gpu.scene.formats.collada.effects import Effect
from gpu.scene.limits import DEFAULT_LIMITS
from gpu.scene.types import Wrap

IMAGE = '<library_images><image id="i"><init_from>a.png</init_from></image></library_images>'


def read(folder: Path, inside: str, params: str = "", extra: str = "") -> tuple[Effect, list[str]]:
    (folder / "a.dae").write_bytes(dae(libraries=IMAGE + effect(f"<phong>{inside}</phong>", params, extra)))
    document = open_document(folder / "a.dae", DEFAULT_LIMITS)
    found = document.find("e", "effect")
    assert found is not None
    made = Effect(document, found, "Red")
    made.opacity(), made.sampler("diffuse"), made.normal_map(), made.say_unread()
    return made, list(document.remarks.sentences())


@pytest.mark.parametrize(
    ("mode", "color", "factor", "opacity"),
    [
        ("", "1 1 1 1", "0.75", 0.75),
        ('opaque="A_ONE"', "0 0 0 0.5", "0.5", 0.25),
        ('opaque="A_ZERO"', "0 0 0 0.25", "1", 0.75),
        ('opaque="RGB_ZERO"', "0.25 0.25 0.25 1", "1", 0.75),
        ('opaque="RGB_ZERO"', "0 0 0 1", "1", 1.0),
        ('opaque="RGB_ONE"', "0.5 0.5 0.5 1", "1", 0.5),
        ("", "1 1 1 1", "0", 1.0),
    ],
)
def test_opacity(tmp_path: Path, mode: str, color: str, factor: str, opacity: float) -> None:
    inside = f"<transparent {mode}><color>{color}</color></transparent>"
    made, said = read(tmp_path, inside + f"<transparency><float>{factor}</float></transparency>")
    assert made.opacity()[0] == pytest.approx(opacity, abs=1e-4)
    assert any("taken as opaque" in sentence for sentence in said) == (factor == "0")


def test_parameters_and_what_is_no_number(tmp_path: Path) -> None:
    params = '<newparam sid="p"><float4>0.1 0.2 0.3 1</float4></newparam>'
    inside = '<diffuse><param ref="p"/></diffuse><emission><color>a</color></emission>'
    made, said = read(tmp_path, inside + "<shininess><float>NaN</float></shininess>", params)
    assert made.color("diffuse", (0, 0, 0)) == (0.1, 0.2, 0.3)
    assert made.color("emission", (7, 7, 7)) == (7, 7, 7)
    assert made.number("shininess", 5.0) == 5.0
    assert "Red: emission is no number and was ignored" not in said  # since nothing had asked for it


def test_a_sampler_is_a_parameter_or_an_image(tmp_path: Path) -> None:
    made, _ = read(tmp_path, '<diffuse><texture texture="t" texcoord="UV"/></diffuse>', TEXTURE)
    sampler = made.sampler("diffuse")
    assert sampler is not None
    assert (sampler.image.get("id"), sampler.texcoord, sampler.wrap_s, sampler.wrap_t) == (
        "i", "UV", Wrap.CLAMP, Wrap.REPEAT
    )  # fmt: skip
    made, _ = read(tmp_path, '<diffuse><texture texture="i" texcoord="UV"/></diffuse>')
    assert made.sampler("diffuse") is not None
    made, said = read(tmp_path, '<diffuse><texture texture="x" texcoord="UV"/></diffuse>')
    assert made.sampler("diffuse") is None
    assert any("'x': a image that the file refers to" in sentence for sentence in said) or said


def test_extras_of_programs(tmp_path: Path) -> None:
    extra = "<extra><technique profile='P'><double_sided>1</double_sided>{}</technique></extra>"
    bump = '<bump bumptype="NORMALMAP"><texture texture="i"/></bump>'
    made, said = read(tmp_path, "", extra=extra.format(bump))
    assert (made.double_sided, made.normal_map() is not None, said) == (True, True, [])
    made, said = read(tmp_path, "", extra=extra.format('<bump><texture texture="i"/></bump>'))
    assert (made.normal_map(), said) == (None, ["Red: bump maps are not shown"])


def test_what_is_not_shown_is_said(tmp_path: Path) -> None:
    _, said = read(tmp_path, '<ambient><texture texture="i"/></ambient><reflective><color>1 1 1 1</color></reflective>'
                   "<reflectivity><float>0.5</float></reflectivity>")  # fmt: skip
    assert said == ["Red: textures of ambient are not shown", "Red: reflectivity is not shown"]
