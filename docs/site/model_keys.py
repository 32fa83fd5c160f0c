"""The schema of model files as tables: each kind of thing with its keys."""

from __future__ import annotations

from typing import Any

Node = dict[str, Any]

_plain = {"number": "number", "integer": "whole number", "string": "text", "boolean": "true or false", "null": "null"}


def model_keys(schema: Node) -> str:
    kinds: dict[str, Node] = schema["$defs"]
    text = _table(schema, kinds)
    for name, node in kinds.items():
        text += f"\n## {name}\n\n" + (f"{_sentence(node['description'])}\n\n" if "description" in node else "")
        forms = [form for form in _forms(node) if "properties" in form]
        others = [form for form in _forms(node) if "properties" not in form]
        if others:
            text += ("Either " if forms else "") + ", or ".join(_type(form, kinds) for form in others)
            text += (", or with keys:" if forms else ".") + "\n\n"
        for k, form in enumerate(forms):
            if k > 0:
                text += "\nor\n\n"
            if len(forms) > 1 and "description" in form:
                text += f"{_sentence(form['description'])}\n\n"
            text += _table(form, kinds)
    return text


def _forms(node: Node) -> list[Node]:
    """What a thing may be written as."""
    forms = [form for key in ("oneOf", "anyOf") for form in node.get(key, []) if set(form) != {"required"}]
    return forms or [node]


def _table(node: Node, kinds: dict[str, Node]) -> str:
    required = set(node.get("required", []))
    rows = "".join(_rows("", node, kinds, required))
    return "| key | value | |\n| --- | --- | --- |\n" + rows


def _rows(prefix: str, node: Node, kinds: dict[str, Node], required: set[str]) -> list[str]:
    rows = []
    for key, value in node["properties"].items():
        needed = "**Required.** " if key in required else ""
        about = (needed + value.get("description", "")).replace("|", "\\|")
        rows.append(f"| `{prefix}{key}` | {_type(value, kinds)} | {about} |\n")
        for form in _inner(value):
            rows += _rows(f"{prefix}{key}.", form, kinds, set(form.get("required", [])))
    return rows


def _inner(node: Node) -> list[Node]:
    """The objects that a value is made of, where they have no name of their own."""
    found = []
    for form in _forms(node):
        for part in (form, form.get("items"), form.get("additionalProperties")):
            if isinstance(part, dict) and "properties" in part:
                found.append(part)
    return found


def _type(node: Node, kinds: dict[str, Node]) -> str:
    if "$ref" in node:
        name = node["$ref"].rsplit("/", 1)[1]
        return f"[{name}](#{name})"
    if "const" in node:
        return f"`{node['const']}`"
    if "enum" in node:
        return ", ".join(f"`{word}`" for word in node["enum"])
    forms = _forms(node)
    if forms != [node]:
        return " or ".join(dict.fromkeys(_type(form, kinds) for form in forms))
    given = node.get("type", [])
    types = [given] if isinstance(given, str) else [kind for kind in given if kind != "null"]
    return " or ".join(dict.fromkeys(_of(kind, node, kinds) for kind in types)) or "anything"


def _of(kind: str, node: Node, kinds: dict[str, Node]) -> str:
    if kind == "array":
        least, most = node.get("minItems"), node.get("maxItems")
        count = f"{least} × " if least is not None and least == most else ""
        return "list of " + count + _type(node.get("items", {}), kinds)
    if kind == "object":
        if "properties" in node:
            return "keys"
        return f"names, each with {_type(node.get('additionalProperties') or {}, kinds)}"
    return _plain[kind]


def _sentence(text: str) -> str:
    return text if text.endswith((".", ":")) else text + "."
