"""Writes web/messages.d.ts, for tsc, from the messages of the wire: `python -m tests.browser.message_types`."""

import json
import re
from pathlib import Path
from typing import Any

from pydantic import BaseModel
from pydantic.json_schema import models_json_schema

from server.wire.browser import (
    Ack,
    Edit,
    Edits,
    Error,
    Hello,
    Own,
    PickedPart,
    Pose,
    SceneInfo,
    Settings,
    Status,
    Welcome,
)

FILE = Path(__file__).parents[2] / "web" / "messages.d.ts"
TO_SERVER = (Hello, Pose, Settings, Edit, Own, Ack)
TO_VIEWER = (Welcome, SceneInfo, Edits, Status, Error)
ANSWERS = (PickedPart,)  # to requests, over REST
# Names that mean something else in a browser.
RENAMED = {"Error": "ServerError"}
# What the page reads or writes field by field, as the schema in the welcome says.
DYNAMIC = {
    "RenderSettings": "Readonly<Record<string, unknown>>",
    "settings_schema": 'import("./ui/schema.js").JsonSchema',
}
PLAIN = {"string": "string", "integer": "number", "number": "number", "boolean": "boolean", "null": "null"}
REFERENCE = re.compile(r'"#/\$defs/(\w+)"')
HEAD = """// The messages of server/wire/browser.py, written by tests/browser/message_types.py: make changes there.

"""


def type_of(schema: dict[str, Any]) -> str:
    """The TypeScript of a JSON schema, as far as messages need it."""
    match schema:
        case {"$ref": str(place)}:
            name = place.rsplit("/", 1)[-1]
            return RENAMED.get(name, name)
        case {"const": value}:
            return json.dumps(value)
        case {"enum": list(values)}:
            return " | ".join(map(json.dumps, values))
        case {"anyOf": list(choices)}:
            return " | ".join(map(type_of, choices))
        case {"prefixItems": list(items)}:
            return f"[{', '.join(map(type_of, items))}]"
        case {"items": dict(item)}:
            kind = type_of(item)
            return f"readonly ({kind})[]" if "|" in kind else f"readonly {kind}[]"
        case {"additionalProperties": dict(value)}:
            return f"Readonly<Record<string, {type_of(value)}>>"
        case {"type": str(kind)}:
            return PLAIN[kind]
    raise ValueError(f"no type is known for {schema}")


def declaration(name: str, schema: dict[str, Any], *, complete: bool) -> str:
    """A type of that name; complete: no field is left out."""
    words = " ".join(str(schema.get("description", "")).split())
    comment = f"/** {words} */\n" if words else ""
    name, dynamic = RENAMED.get(name, name), DYNAMIC.get(name)
    if dynamic or "properties" not in schema:
        return f"{comment}export type {name} = {dynamic or type_of(schema)};\n"
    lines = []
    for field, of in schema["properties"].items():
        lines += [f"  /** {of['description']} */"] if "description" in of else []
        mark = "" if complete or field in schema.get("required", ()) else "?"
        lines.append(f"  {field}{mark}: {DYNAMIC.get(field) or type_of(of)};")
    return f"{comment}export interface {name} {{\n" + "\n".join(lines) + "\n}\n"


def declarations(models: tuple[type[BaseModel], ...], *, complete: bool) -> dict[str, str]:
    """The types of messages and of what is in them, by name."""
    _, schema = models_json_schema([(model, "validation") for model in models])
    found: dict[str, str] = {}

    def visit(name: str) -> None:
        if name not in found:
            definition = schema["$defs"][name]
            found[name] = declaration(name, definition, complete=complete)
            for inner in () if name in DYNAMIC else REFERENCE.findall(json.dumps(definition)):
                visit(inner)

    for model in models:
        visit(model.__name__)
    return found


def union(name: str, models: tuple[type[BaseModel], ...]) -> str:
    """A type of any of these messages."""
    return f"export type {name} = {' | '.join(RENAMED.get(model.__name__, model.__name__) for model in models)};\n"


def text() -> str:
    """The whole file."""
    # The page may leave out what has a default; the server says all, also of what both may say.
    types = declarations(TO_SERVER, complete=False)
    types |= {name: of for name, of in declarations(TO_VIEWER + ANSWERS, complete=True).items() if name not in types}
    unions = union("ViewerMessage", TO_SERVER), union("ServerMessage", TO_VIEWER)
    return HEAD + "\n".join([*types.values(), *unions])


if __name__ == "__main__":
    FILE.write_text(text())
