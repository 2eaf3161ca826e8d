"""What Warp makes of functions, and their hashes, kept: they are made once, not anew for each kernel that calls them.

Warp makes the code of kernels in Python, one after the other, which takes as long as compilers with many cores do.
"""

from collections.abc import Hashable
from dataclasses import dataclass
from typing import Any

import warp as wp
from warp._src.codegen import Adjoint, Struct, strip_reference
from warp._src.context import Function, Module, ModuleBuilder, ModuleHasher

from gpu.core.code_generation import CONSTANTS, FIELDS_READ

# Options of modules that compilers are told alone, and those that are looked up field by field.
_NOT_IN_CODE = {"fast_math", CONSTANTS}
# Of a function as it was found: its code.
_CODE = "kept_code"
_BUILDS = "kept_builds"
_HASH = "kept_hash"

_codegen = wp._src.codegen
_resolve_func, _build_function, _function_code, _hash_function = (
    Adjoint.resolve_func, ModuleBuilder.build_function, _codegen.codegen_func, ModuleHasher.hash_function
)  # fmt: skip
_overloads: dict[Hashable, Any] = {}


@dataclass(frozen=True)
class _Build:
    """What Warp found out of a function for a module of such options, where fields were taken for such constants."""

    options: str
    read: dict[str, bool | int | None]
    found: dict[str, Any]

    def holds(self, options: str, constants: dict[str, bool | int]) -> bool:
        """Whether it would be the same for another module."""
        return self.options == options and all(constants.get(field) == value for field, value in self.read.items())


def _overload(adj: Adjoint, func: Any, arg_types: tuple[Any, ...], kwarg_types: dict[str, Any], outputs: Any) -> Any:
    """Which overload of a builtin takes arguments of these types; Warp tries one after the other."""
    asked = func, arg_types, tuple(kwarg_types.items()), outputs
    try:
        if asked not in _overloads and func.is_builtin():
            _overloads[asked] = _resolve_func(adj, func, arg_types, kwarg_types, outputs)
        return _overloads[asked]
    except (KeyError, TypeError):  # a function of ours, or types that cannot be looked up
        return _resolve_func(adj, func, arg_types, kwarg_types, outputs)


def _kept_function(builder: ModuleBuilder, func: Any) -> None:
    """Have a function in a module, with all that it calls; what was found out of it is taken where it holds."""
    if func in builder.functions:
        return
    adj, builds = func.adj, vars(func).setdefault(_BUILDS, [])
    options = repr([builder.target, *(item for item in builder.options.items() if item[0] not in _NOT_IN_CODE)])
    constants = builder.options.get(CONSTANTS, {})
    kept = next((build for build in builds if build.holds(options, constants)), None)
    if kept is None:
        vars(adj).update({FIELDS_READ: {}, _CODE: {}})
        _build_function(builder, func)
        builds.append(_Build(options, dict(vars(adj)[FIELDS_READ]), dict(vars(adj))))
        return
    for called in kept.found["called_user_functions"]:
        builder.build_function(called)
    vars(adj).update(kept.found)
    for variable in (*adj.args, *adj.variables, *(adj.return_var or ())):
        builder._collect_native_types(variable.type)
        kind = strip_reference(variable.type)
        kind = getattr(kind, "dtype", kind)
        if isinstance(kind, Struct):
            builder.build_struct_recursive(kind)
    builder.functions[func] = None


def _kept_code(adj: Adjoint, c_func_name: str, *, options: dict[str, Any], **how: Any) -> str:
    """A function's code as Warp made it, if it did."""
    asked = c_func_name, *how.items()
    kept: dict[Hashable, str] = vars(adj).setdefault(_CODE, {})
    if asked not in kept:
        kept[asked] = _function_code(adj, c_func_name, options=options, **how)
    return kept[asked]


def _kept_hash(hasher: ModuleHasher, func: Function) -> bytes:
    """A function's hash, of all that it calls, too; Warp keeps it for one module alone.

    What it calls and the constants that it reads must not change once a kernel that calls it has been loaded.
    """
    overloads = {**func.user_overloads, **func.user_templates}
    kept: tuple[dict[str, Function], bytes] | None = vars(func).get(_HASH)
    if kept is None or kept[0] != overloads:
        kept = vars(func)[_HASH] = overloads, _hash_function(hasher, func)
    return kept[1]


def _find_no_references(module: Module, adj: Adjoint) -> None:
    """Leave out which modules a function's needs to be loaded again with: here none is ever loaded again, and to look
    through all functions as they are imported takes a tenth of that.
    """


def keep_functions() -> None:
    """Have Warp keep them, from now on."""
    Module._find_references = _find_no_references
    ModuleHasher.hash_function = _kept_hash
    Adjoint.resolve_func = _overload
    ModuleBuilder.build_function = _kept_function
    _codegen.codegen_func = _kept_code
