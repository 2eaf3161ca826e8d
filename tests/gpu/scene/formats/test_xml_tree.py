import numpy as np
import pytest

from gpu.errors import SceneError
from gpu.scene.formats.xml_tree import attribute_rows, number_row, text_of, xml_root

LAUGHS = '<!DOCTYPE a [<!ENTITY b "ha"><!ENTITY c "&b;&b;&b;">]><a>&c;</a>'
OUTSIDE = '<!DOCTYPE a [<!ENTITY b SYSTEM "file:///etc/passwd">]><a>&b;</a>'


def test_names_come_without_their_namespaces() -> None:
    root = xml_root("a.xml", b'<x:a xmlns:x="urn:x" x:path="1" b="2"><x:c> 3 </x:c></x:a>')
    assert (root.tag, root.attrib, text_of(root.find("c")), text_of(root.find("d"))) == (
        "a", {"path": "1", "b": "2"}, "3", ""
    )  # fmt: skip


@pytest.mark.parametrize("encoding", ["utf-8", "utf-16"])
@pytest.mark.parametrize("text", [LAUGHS, OUTSIDE, '<!DOCTYPE a SYSTEM "http://localhost/a.dtd"><a/>'])
def test_a_document_type_is_refused(text: str, encoding: str) -> None:
    with pytest.raises(SceneError, match="declares a document type"):
        xml_root("a.xml", text.encode(encoding))


@pytest.mark.parametrize(
    "content", [b"", b"<a>", b"<a>&b;</a>", b"<a/>\0", b"\xff\xfe", b'<?xml version="1.0" encoding="x"?><a/>']
)
def test_what_is_no_xml_is_refused(content: bytes) -> None:
    with pytest.raises(SceneError, match=r"a\.xml: part: not XML that"):
        xml_root("a.xml", content, "part")


def test_an_empty_line_may_come_first() -> None:
    assert xml_root("a.xml", b'\r\n <?xml version="1.0"?><a/>').tag == "a"


def test_numbers() -> None:
    assert number_row(" 1 2e3\n-4 ").tolist() == [1.0, 2000.0, -4.0]
    assert np.isnan(number_row("-1.#IND")).all()
    for wrong in ("1,5", "0x1", "1_0"):
        with pytest.raises(ValueError, match=r"."):
            number_row(wrong)


def test_rows_of_attributes() -> None:
    root = xml_root("a.xml", b'<a><b x="1" y="2"/><b x="3" y="4"/></a>')
    assert attribute_rows(iter(root), ("x", "y")).tolist() == [[1, 2], [3, 4]]
    with pytest.raises(KeyError):
        attribute_rows(iter(root), ("x", "z"))
    with pytest.raises(ValueError, match=r"."):
        attribute_rows(iter(xml_root("a.xml", b'<a><b x=""/><b x="1 2"/></a>')), ("x",))
