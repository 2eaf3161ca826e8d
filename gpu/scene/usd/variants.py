"""Variants of a stage: those that the file selects, or one that a user chose, named as USD does: /Prim{set=name}."""

from typing import Any

from pxr import Usd

from gpu.errors import SceneError


def choose_variant(source: str, usd: Any, wanted: str | None) -> list[str]:
    """The variants that the stage `usd` offers, the `wanted` one selected. Raises SceneError if it does not exist."""
    offered = {
        f"{prim.GetPath()}{{{name}={variant}}}": (prim.GetVariantSets(), name, variant)
        for prim in usd.Traverse()
        for name in prim.GetVariantSets().GetNames()
        for variant in prim.GetVariantSets().GetVariantSet(name).GetVariantNames()
    }
    if wanted is not None:
        if wanted not in offered:
            known = f"there are {', '.join(list(offered)[:20])}" if offered else "the file has no variants"
            raise SceneError(source, "variant", f"{wanted!r:.80} does not exist; {known}")
        sets, name, variant = offered[wanted]
        usd.SetEditTarget(Usd.EditTarget(usd.GetSessionLayer()))
        sets.SetSelection(name, variant)
    return list(offered)
