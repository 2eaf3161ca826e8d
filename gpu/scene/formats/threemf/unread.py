"""What a 3MF file has and this reader does not use, for the scene's report."""

from collections import Counter
from xml.etree.ElementTree import Element

from gpu.scene.remarks import Remarks

# What is read, said elsewhere, or only describes the file.
_KNOWN = {
    *("model", "metadata", "metadatagroup", "resources", "build", "item", "object", "mesh", "vertices", "vertex"),
    *("triangles", "triangle", "components", "component", "basematerials", "base", "colorgroup", "color"),
    *("texture2d", "texture2dgroup", "tex2coord", "compositematerials", "composite", "multiproperties", "multi"),
}
_WORDS = {
    "beamlattice": "beam lattices",
    "slicestack": "stacks of slices",
    "pbspeculardisplayproperties": "properties for display (pbspecular)",
    "pbmetallicdisplayproperties": "properties for display (pbmetallic)",
    "pbspeculartexturedisplayproperties": "textures for display (pbspecular)",
    "pbmetallictexturedisplayproperties": "textures for display (pbmetallic)",
    "translucentdisplayproperties": "translucency for display",
    "trianglesets": "sets of triangles",
}


def say_unread(root: Element, file: str, remarks: Remarks) -> None:
    """Say what the model `root` of a package's `file` has and nothing shows, once for each kind."""
    found: Counter[str] = Counter()
    waiting = [root]
    while waiting:
        element = waiting.pop()
        if element.tag in _KNOWN:
            waiting += element
        else:  # what is in it is part of it
            found[_WORDS.get(element.tag, f"elements {element.tag:.40}")] += 1
    for words, count in sorted(found.items()):
        remarks.add(f"{words} are not shown ({count:,})", file, words)
