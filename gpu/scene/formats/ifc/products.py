"""Which products of an IFC model are shown: those with a body, of the storeys that are asked for."""

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from gpu.errors import SceneError

# Spaces, holes and aids to drawing and analysis: their shapes are not bodies to be seen.
_NO_BODIES = (
    "IfcSpace",
    "IfcSpatialZone",
    "IfcExternalSpatialStructureElement",
    "IfcFeatureElement",
    "IfcVirtualElement",
    "IfcAnnotation",
    "IfcGrid",
    "IfcPort",
    "IfcStructuralItem",
    "IfcStructuralActivity",
    "IfcLinearPositioningElement",
    "IfcReferent",
)
_BODIES = {"Body", "Facetation", "Tessellation"}
# From a part to the whole that it belongs to, by inverse and attribute of the relation.
_WHOLES = (
    ("ContainedInStructure", "RelatingStructure"),
    ("Decomposes", "RelatingObject"),
    ("Nests", "RelatingObject"),
    ("FillsVoids", "RelatingOpeningElement"),
    ("VoidsElements", "RelatingBuildingElement"),
)


@dataclass(frozen=True)
class Chosen:
    """The products to be `shown`; the names of storeys that have any, from the lowest; what was left out."""

    shown: list[Any]
    storeys: tuple[str, ...]
    sentences: list[str]


def choose_products(source: str, model: Any, names: Sequence[str]) -> Chosen:
    """The products of `model` with a body that are in storeys called `names`, or anywhere if there are none.

    Raises SceneError for a name that no storey with products has.
    """
    shaped = [product for product in model.by_type("IfcProduct") if _shapes(product)]
    no_bodies = Counter(product.is_a() for product in shaped if any(product.is_a(kind) for kind in _NO_BODIES))
    bodies = [product for product in shaped if product.is_a() not in no_bodies]
    outlines = [product for product in bodies if not _has_body(product)]
    solid = [product for product in bodies if _has_body(product)]
    sentences = []
    if no_bodies:
        counts = ", ".join(f"{count} {kind}" for kind, count in sorted(no_bodies.items()))
        sentences.append(f"what is no body is not shown: {counts}")
    if outlines:
        sentences.append(f"elements with an axis or an outline but no body, not shown: {len(outlines)}")

    storeys = {product.id(): storey for product in solid if (storey := storey_of(product))}
    by_height = sorted(storeys.values(), key=lambda storey: storey.Elevation or 0.0)
    known = tuple(dict.fromkeys(map(_name, by_height)))
    if unknown := [name for name in names if name not in known]:
        there = f"there are {', '.join(known)}" if known else "the file has none"
        raise SceneError(source, "storeys", f"no storey is called {', '.join(unknown)}; {there}")
    if names:
        shown = [product for product in solid if product.id() in storeys and _name(storeys[product.id()]) in names]
        sentences.append(f"elements outside the chosen storeys, not shown: {len(solid) - len(shown)}")
        solid = shown
    return Chosen(solid, known, sentences)


def storey_of(product: Any) -> Any | None:
    """The storey that `product`, or the whole that it is a part of, is contained in; None if in none."""
    seen = set[int]()
    while product is not None and product.id() not in seen:
        if product.is_a("IfcBuildingStorey"):
            return product
        seen.add(product.id())
        wholes = [getattr(relation, one, None) for many, one in _WHOLES for relation in getattr(product, many, ())]
        product = wholes[0] if wholes else None
    return None


def _name(storey: Any) -> str:
    return str(storey.Name or storey.GlobalId)


def _has_body(product: Any) -> bool:
    kinds = (getattr(shape, "RepresentationIdentifier", "") for shape in _shapes(product))
    return any(kind is None or kind in _BODIES for kind in kinds)


def _shapes(product: Any) -> Sequence[Any]:
    """The representations of `product`; none where the file refers to something else."""
    return getattr(product.Representation, "Representations", None) or ()
