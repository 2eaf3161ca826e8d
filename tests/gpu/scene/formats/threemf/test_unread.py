"""What a 3MF model has and nothing shows is said once a kind, with a count."""

from threemf_file import mesh, model

from gpu.scene.formats.threemf.unread import say_unread
from gpu.scene.formats.xml_tree import xml_root
from gpu.scene.remarks import Remarks


def said(resources: str) -> tuple[str, ...]:
    remarks = Remarks()
    say_unread(xml_root("a.3mf", model(resources).encode()), "3D/a.model", remarks)
    return remarks.sentences()


def test_what_is_read_is_not_said() -> None:
    read = f'<basematerials id="2"><base name="oak"/></basematerials><object id="1">{mesh()}</object>'
    assert said(read) == ()


def test_properties_for_display_and_what_is_not_known_are_named() -> None:
    metals = "<pbmetallicdisplayproperties><pbmetallic/><pbmetallic/></pbmetallicdisplayproperties>"
    assert said(metals + metals + "<m:volumetric/><vendor><mesh/><other/></vendor>") == (
        "3D/a.model: elements vendor are not shown (1)",
        "3D/a.model: elements volumetric are not shown (1)",
        "3D/a.model: properties for display (pbmetallic) are not shown (2)",
    )
