import pytest
from usd_file import UsdFile

from gpu.errors import SceneError
from gpu.scene.formats.usd import load_usd
from gpu.scene.import_options import ImportOptions


def chairs(usd: UsdFile) -> None:
    prim = usd.stage.DefinePrim("/Chair", "Xform")
    look = prim.GetVariantSets().AddVariantSet("look")
    for number, name in enumerate(("plain", "armed"), 1):
        look.AddVariant(name)
        look.SetVariantSelection(name)
        with look.GetVariantEditContext():
            for part in range(number):
                usd.mesh(f"/Chair/Part{part}")
    look.SetVariantSelection("plain")


def test_the_files_own_choice_and_anothers(usd: UsdFile) -> None:
    chairs(usd)
    path = usd.write()
    scene = load_usd(path)
    assert list(scene.choices["variant"]) == ["/Chair{look=armed}", "/Chair{look=plain}"]
    assert len(scene.triangles) == 2
    assert len(load_usd(path, options=ImportOptions(variant="/Chair{look=armed}")).triangles) == 4


def test_a_variant_that_is_not_there(usd: UsdFile) -> None:
    chairs(usd)
    with pytest.raises(SceneError, match=r"no variant ./Chair\{look=gold\}. in it; it has /Chair\{look=armed\}"):
        load_usd(usd.write(), options=ImportOptions(variant="/Chair{look=gold}"))


def test_a_file_without_variants(usd: UsdFile) -> None:
    usd.mesh()
    assert not usd.load().choices
    with pytest.raises(SceneError, match="no variant 'any' in it; it has none"):
        load_usd(usd.write(), options=ImportOptions(variant="any"))
