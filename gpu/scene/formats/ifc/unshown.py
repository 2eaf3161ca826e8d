"""What an IFC model says beside bodies and colours, and lumenwalk does not show."""

from typing import Any

_SENTENCES = {
    "IfcLightSource": "light sources (IfcLightSource) are not supported and give no light",
    "IfcLightFixture": "light fixtures (IfcLightFixture) are shown but give no light",
    "IfcSurfaceStyleWithTextures": "textures of styles are not supported; their colours count",
    "IfcIndexedColourMap": "colours of single faces (IfcIndexedColourMap) are not supported",
    "IfcSurfaceStyleLighting": "colours of light (IfcSurfaceStyleLighting) are not supported",
}


def unshown_kinds(model: Any) -> list[str]:
    """A sentence for each kind of thing in `model` that is not shown, with its count."""
    counts = {kind: len(entities(model, kind)) for kind in _SENTENCES}
    return [f"{sentence}: {counts[kind]}" for kind, sentence in _SENTENCES.items() if counts[kind]]


def entities(model: Any, kind: str) -> list[Any]:
    """The entities of a `kind` in `model`; none where its schema does not know the kind."""
    try:
        return list(model.by_type(kind))
    except RuntimeError:
        return []
