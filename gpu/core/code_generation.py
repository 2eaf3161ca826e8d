"""What Warp is told besides about the code that it makes of kernels, so that compilers have less of it."""

import ast
from typing import Any, TypeVar

import warp as wp
from warp._src.codegen import Adjoint, Struct, strip_reference

# An option of a module that Warp keeps and hashes as it does its own.
CONSTANTS = "constant_fields"
# Of a kernel or function: the fields of structs by reference that it reads, and the constants they were taken for.
FIELDS_READ = "fields_read"

_T = TypeVar("_T")

_by_reference: set[Struct] = set()
_codegen = wp._src.codegen
_emit_if, _emit_attribute = (Adjoint.node_visitors[kind] for kind in (ast.If, ast.Attribute))
_codegen_func = _codegen.codegen_func

# Of every struct a module has functions for adjoints, which nothing here calls: compilers leave out those that no other
# module could.
_codegen.struct_template = _codegen.struct_template.replace("\nCUDA_CALLABLE", "\nstatic CUDA_CALLABLE")


def pass_by_reference(struct: _T) -> _T:
    """Have functions that do not write to an argument of this struct take it by reference, not as a copy.

    Where they are inlined all the same, it is compilers that copy: a struct of a kilobyte, at each call.
    """
    _by_reference.add(struct)
    return struct


def tell_constants(kernel: wp.Kernel, struct: Struct, constants: dict[str, bool | int]) -> None:
    """Have a kernel with a module of its own, and all that it calls, take fields of a struct for constants.

    A compiler gets each function without what it does otherwise; told by what the kernel writes to the struct, it finds
    that out only once all functions are inlined. Where fields are written, that holds for none who reads them. Raises
    ValueError where the kernel was told other constants.
    """
    told = {f"{struct.key}.{field}": value for field, value in sorted(constants.items())}
    if kernel.module.options.setdefault(CONSTANTS, told) != told:
        raise ValueError(f"{kernel.key} is told {told} and {kernel.module.options[CONSTANTS]}")
    kernel.module.mark_modified()


def _told(adj: Adjoint, node: ast.AST) -> bool | int | None:
    """What an expression is by the constants that were told; None where these do not decide it."""
    match node:
        case ast.Constant(value=int(value)):
            return value
        case ast.Attribute(value=ast.Name(id=name)):
            struct = strip_reference(getattr(adj.symbols.get(name), "type", None))
            if struct not in _by_reference:
                return None
            field = f"{struct.key}.{node.attr}"
            known: bool | int | None = adj.builder_options.get(CONSTANTS, {}).get(field)
            vars(adj).setdefault(FIELDS_READ, {})[field] = known
            return known
        case ast.UnaryOp(op=ast.Not(), operand=operand):
            turned = _told(adj, operand)
            return None if turned is None else not turned
        case ast.Compare(left=left, ops=[ast.Gt()], comparators=[right]):
            more, less = _told(adj, left), _told(adj, right)
            return None if more is None or less is None else more > less
        case ast.BoolOp(op=op, values=operands):
            decides = isinstance(op, ast.Or)
            told = [_told(adj, operand) for operand in operands]
            if any(value is not None and bool(value) is decides for value in told):
                return decides
            return None if None in told else not decides
    return None


def _if(adj: Adjoint, node: ast.If) -> None:
    """Only what happens, where constants decide it."""
    if (value := _told(adj, node.test)) is None:
        _emit_if(adj, node)
        return
    for statement in node.body if value else node.orelse:
        adj.eval(statement)


def _attribute(adj: Adjoint, node: ast.Attribute) -> Any:
    """A field that is read, elsewhere: a variable of that value, since a constant could not be written to in loops."""
    if (value := _told(adj, node)) is not None:
        return adj.add_builtin_call("copy", [adj.add_constant(value)])
    return _emit_attribute(adj, node)


def _writes(function: ast.AST, name: str) -> bool:
    """Whether a function assigns to a variable, or to what is in it."""
    for node in ast.walk(function):
        if isinstance(getattr(node, "ctx", None), ast.Store):
            while isinstance(node, ast.Attribute | ast.Subscript):
                node = node.value
            if isinstance(node, ast.Name) and node.id == name:
                return True
    return False


class _Reference:
    """The type of an argument in C++, which is asked for it first where the function is declared."""

    def __init__(self, ctype: str) -> None:
        self.ctype, self.declared = ctype, False

    def __call__(self, *_: Any, **__: Any) -> str:
        declared, self.declared = self.declared, True
        return self.ctype if declared else f"{self.ctype} &"


def _function_code(adj: Adjoint, c_func_name: str, device: str = "cpu", *rest: Any, **options: Any) -> str:
    """As Warp's, with arguments by reference; for GPUs inlined, as they are with copies."""
    references = [one for one in adj.args if one.type in _by_reference and not _writes(adj.tree, one.label)]
    for one in references:
        one.ctype = _Reference(one.ctype())
    try:
        if device == "cuda" and options.get("inline_hint") is None:
            options["inline_hint"] = "forceinline"
        return str(_codegen_func(adj, c_func_name, device, *rest, **options))
    finally:
        for one in references:
            del one.ctype


Adjoint.node_visitors |= {ast.If: _if, ast.Attribute: _attribute}
_codegen.codegen_func = _function_code
