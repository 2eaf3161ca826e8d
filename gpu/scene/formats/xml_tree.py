"""XML of scene files as a tree, without what XML can do beyond that: no entities, nothing fetched."""

from collections.abc import Iterator
from xml.etree import ElementTree
from xml.etree.ElementTree import Element

import numpy as np

from gpu.errors import SceneError
from gpu.scene.formats.text import numbers
from gpu.scene.types import Doubles


class _Builder(ElementTree.TreeBuilder):
    """Builds a tree and refuses a document type, which is where entities are declared."""

    def doctype(self, name: str, pubid: str | None, system: str | None) -> None:
        """Called for <!DOCTYPE …>, before any of its declarations."""
        raise ValueError("it declares a document type, which scene files do not need; remove <!DOCTYPE …>")


def xml_root(source: str, content: bytes, field: str = "") -> Element:
    """The root of the XML file `content`; names of elements and attributes come without their namespaces.

    Raises SceneError naming the line when it is not well-formed, and when it declares a document type.
    """
    parser = ElementTree.XMLParser(target=_Builder())
    try:
        parser.feed(content.lstrip())  # programs begin with an empty line, before which nothing may stand
        root: Element = parser.close()
    except ElementTree.ParseError as error:
        raise SceneError(source, field, f"not XML that can be read: {error}") from error
    except (ValueError, LookupError) as error:  # of an encoding that is not known, too
        raise SceneError(source, field, f"not XML that is read: {error}") from error
    for element in root.iter():
        element.tag = _local(element.tag)
        if any(name[0] == "{" for name in element.attrib):
            element.attrib = {_local(name): value for name, value in element.attrib.items()}
    return root


def text_of(element: Element | None) -> str:
    """The text in `element`, without white space around it; nothing where there is no such element."""
    return ((element.text or "") if element is not None else "").strip()


def number_row(text: str) -> Doubles:
    """The numbers (number,) in `text`, split by white space. Raises ValueError where a word is none."""
    words = text.split()
    try:
        return numbers(words) if "_" in text else np.array(words, np.float64)
    except ValueError:
        return numbers(words)  # as programs write what is no number


def attribute_rows(elements: Iterator[Element], names: tuple[str, ...]) -> Doubles:
    """The numbers (element, name) in attributes. Raises KeyError for a missing one, ValueError for one that is none."""
    words = [element.attrib[name] for element in elements for name in names]
    return number_row(" ".join(word or "?" for word in words)).reshape(-1, len(names))


def _local(name: str) -> str:
    return name.rpartition("}")[2]
