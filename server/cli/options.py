"""Command-line options made from pydantic models, so that names, limits and help are written once, in the model."""

from argparse import SUPPRESS, ArgumentParser, ArgumentTypeError, BooleanOptionalAction, Namespace, _ArgumentGroup
from enum import Enum
from types import NoneType
from typing import Any, Literal, TypeVar, get_args, get_origin

from pydantic import BaseModel, ValidationError
from pydantic.fields import FieldInfo

from gpu.errors import UserError
from server.refusals import reason

Model = TypeVar("Model", bound=BaseModel)


def add_options(parser: ArgumentParser, model: type[BaseModel], title: str) -> None:
    """Add one option per field of `model` under the heading `title`: field `sp_clusters` becomes --sp-clusters.

    Texts stay as they are until the model validates them. An option that is not given is not in the namespace, so that
    the model's own defaults (or environment, or file) count. A model of switches within `model` gets one option, which
    takes the names of those to switch off: field `skip` becomes --no-skip. Other models within get none.
    """
    group = parser.add_argument_group(title)
    for name, field in model.model_fields.items():
        kind = kind_of(field)
        details: dict[str, Any] = {"dest": name, "default": SUPPRESS, "help": _help(field)}
        if kind is bool:
            details["action"] = BooleanOptionalAction
        elif isinstance(kind, type) and issubclass(kind, BaseModel):
            if all(inner.annotation is bool for inner in kind.model_fields.values()):
                _add_switches(group, name, field.description or "", list(kind.model_fields))
            continue
        elif isinstance(kind, type) and issubclass(kind, Enum):
            details["choices"] = [member.value for member in kind]
        elif get_origin(kind) is Literal:
            details["choices"] = get_args(kind)
        else:
            details["metavar"] = {int: "N", float: "X"}.get(kind, "TEXT")
        group.add_argument(flag_of(name), **details)


def _add_switches(group: _ArgumentGroup, name: str, description: str, switches: list[str]) -> None:
    def off(text: str) -> dict[str, bool]:
        names = text.split(",")
        if wrong := [name for name in names if name not in switches]:
            raise ArgumentTypeError(f"{wrong[0]!r} is none of {', '.join(switches)}")
        return dict.fromkeys(names, False)

    words = f"without {description}: {', '.join(switches)}; comma-separated"
    group.add_argument(
        "--no-" + name.replace("_", "-"), dest=name, default=SUPPRESS, type=off, metavar="NAME,…", help=words
    )


def given_options(options: Namespace, model: type[BaseModel]) -> dict[str, Any]:
    """Return the fields of `model` that the command line gave, not yet validated."""
    return {name: value for name, value in vars(options).items() if name in model.model_fields}


def model_from(options: Namespace, model: type[Model]) -> Model:
    """Return `model` with the options that were given; raises UserError that names the first wrong option."""
    try:
        return model(**given_options(options, model))
    except ValidationError as error:
        problem = error.errors(include_url=False)[0]
        raise UserError(f"{flag_of(str(problem['loc'][0]))}: {reason(problem)}, got {problem['input']!r}") from None


def flag_of(name: str) -> str:
    """The option of a field: sp_clusters becomes --sp-clusters."""
    return "--" + name.replace("_", "-")


def kind_of(field: FieldInfo) -> Any:
    """The field's type without `| None`."""
    kinds = [kind for kind in get_args(field.annotation) if kind is not NoneType]
    return kinds[0] if len(kinds) == 1 and NoneType in get_args(field.annotation) else field.annotation


def _help(field: FieldInfo) -> str:
    """Description, limits and default, as argparse wants them (% doubled)."""
    notes = [limits] if (limits := limits_of(field)) else []
    default = field.get_default(call_default_factory=True, validated_data={})
    if default not in (None, (), "") and kind_of(field) is not bool:
        words = ",".join(default) if isinstance(default, tuple) else default
        notes.append(f"default {words.value if isinstance(words, Enum) else words}")
    text = field.description or ""
    return (f"{text} ({'; '.join(notes)})" if notes else text).replace("%", "%%")


def limits_of(field: FieldInfo) -> str:
    """What the field's constraints say, in words."""
    words = {"ge": "at least", "gt": "above", "le": "at most", "lt": "below"}
    bounds = {key: getattr(limit, key) for limit in field.metadata for key in words if hasattr(limit, key)}
    if set(bounds) == {"ge", "le"}:
        return f"{bounds['ge']} to {bounds['le']}"
    return ", ".join(f"{words[key]} {bound:{'d' if isinstance(bound, int) else 'g'}}" for key, bound in bounds.items())
