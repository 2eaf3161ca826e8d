"""Variants of a stage: those that the file selects, or one that a user chose, named as USD does: /Prim{set=name}."""

from typing import Any

from pxr import Usd


def choose_variant(usd: Any, wanted: str | None) -> list[str]:
    """The variants that the stage `usd` offers, the `wanted` one selected; `assemble` refuses one that is not there."""
    offered = {
        f"{prim.GetPath()}{{{name}={variant}}}": (prim.GetVariantSets(), name, variant)
        for prim in usd.Traverse()
        for name in prim.GetVariantSets().GetNames()
        for variant in prim.GetVariantSets().GetVariantSet(name).GetVariantNames()
    }
    if wanted in offered:
        sets, name, variant = offered[wanted]
        usd.SetEditTarget(Usd.EditTarget(usd.GetSessionLayer()))
        sets.SetSelection(name, variant)
    return list(offered)
