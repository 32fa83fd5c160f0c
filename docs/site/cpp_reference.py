"""A page for each public header of the library, from its comments as Doxygen reads them. The pages are plain Markdown:
another program may make the site of them."""

from __future__ import annotations

import re
import subprocess
from pathlib import Path
from xml.etree import ElementTree

Node = ElementTree.Element

_options = """\
INPUT = {include}
RECURSIVE = YES
STRIP_FROM_PATH = {include}
INCLUDE_PATH = {include}
OUTPUT_DIRECTORY = {output}
GENERATE_HTML = NO
GENERATE_LATEX = NO
GENERATE_XML = YES
XML_PROGRAMLISTING = NO
EXTRACT_ALL = YES
AUTOLINK_SUPPORT = NO
QUIET = YES
WARNINGS = NO
"""
_special = re.compile(r"([\\`*_\[\]<>|#])")
_parts = ("class", "struct", "union")


def cpp_pages(include: Path, output: Path) -> dict[str, str]:
    """Of each header under `include`, as "mimbre/run.h", its page."""
    output.mkdir(parents=True, exist_ok=True)
    options = _options.format(include=include, output=output)
    subprocess.run(["doxygen", "-"], input=options, text=True, check=True, capture_output=True)
    compounds = [_root(file) for file in sorted((output / "xml").glob("*.xml")) if file.stem != "index"]
    entries: dict[str, list[tuple[int, str]]] = {}
    for compound in compounds:
        kind = compound.get("kind", "")
        if kind in _parts and "@" not in _name(compound):
            file, line = _place(compound)
            entries.setdefault(file, []).append((line, _class(compound)))
        elif kind in ("namespace", "file"):
            for member in compound.iterfind("sectiondef/memberdef"):
                file, line = _place(member)
                text = f"## {_escaped(_name(member))}\n\n" + _member(member)
                if (line, text) not in entries.setdefault(file, []):  # a file also lists those of its namespace
                    entries[file].append((line, text))
    pages = {}
    for header in sorted(include.rglob("*.h")):
        name = header.relative_to(include).as_posix()
        head = f"# {name}\n\n{_intention(header.read_text(encoding='utf-8'))}"
        pages[name] = head + "\n".join(text for _, text in _merged(sorted(entries.get(name, []))))
    return pages


def _root(file: Path) -> Node:
    compound = ElementTree.parse(file).getroot().find("compounddef")
    return compound if compound is not None else ElementTree.Element("none")


def _merged(entries: list[tuple[int, str]]) -> list[tuple[int, str]]:
    """Functions of one name in a row share a heading."""
    merged: list[tuple[int, str]] = []
    last = ""
    for line, text in entries:
        heading, _, rest = text.partition("\n\n")
        merged.append((line, rest if heading == last else text))
        last = heading
    return merged


def _intention(header: str) -> str:
    """The comment above the namespace says what a header is for."""
    found = re.search(r"((?:^///.*\n)+)\s*namespace", header, re.MULTILINE)
    if not found:
        return ""
    text = " ".join(line.removeprefix("///").strip() for line in found[1].splitlines())
    return f"{_special.sub(_kept, text)}\n\n"


def _kept(mark: re.Match[str]) -> str:
    return mark[1] if mark[1] in "`[]" else "\\" + mark[1]


def _name(node: Node) -> str:
    name = node.findtext("compoundname") or node.findtext("name") or ""
    return name.removeprefix("mimbre::")


def _place(node: Node) -> tuple[str, int]:
    place = node.find("location")
    if place is None:
        return "", 0
    return place.get("file", ""), int(place.get("line", "0"))


def _class(compound: Node) -> str:
    members = [one for one in compound.iterfind("sectiondef/memberdef") if one.get("prot") == "public"]
    data = [one for one in members if one.get("kind") == "variable"]
    text = f"## {_escaped(_name(compound))}\n\n{_about(compound)}"
    if data:
        rows = (f"| `{_declaration(one).removesuffix(';')}` | {_in_a_line(one)} |\n" for one in data)
        text += "| member | |\n| --- | --- |\n" + "".join(rows) + "\n"
    return text + "".join(_member(one) for one in members if one not in data)


def _in_a_line(node: Node) -> str:
    return " ".join(_about(node).split())


def _member(member: Node) -> str:
    """Its declaration, then what its comment says."""
    return f"```cpp\n{_declaration(member)}\n```\n\n{_about(member)}"


def _declaration(member: Node) -> str:
    name = member.findtext("name") or ""
    kind = member.get("kind")
    if kind == "enum":
        values = ", ".join(value.findtext("name") or "" for value in member.iterfind("enumvalue"))
        return f"enum {'class ' if member.get('strong') == 'yes' else ''}{name} {{ {values} }};"
    type_of = _plain(member.find("type"))
    template = ", ".join(
        _plain(one.find("type")) + f" {one.findtext('declname') or ''}".rstrip()
        for one in member.iterfind("templateparamlist/param")
    )
    words = [f"template <{template}>\n" if template else "", "static " if member.get("static") == "yes" else ""]
    if kind == "typedef":
        return f"using {name} = {type_of};"
    if kind == "variable":
        return "".join(words) + f"{type_of} {name} {member.findtext('initializer') or ''}".rstrip() + ";"
    virtual = "virtual " if member.get("virt") in ("virtual", "pure-virtual") else ""
    explicit = "explicit " if member.get("explicit") == "yes" else ""
    arguments = member.findtext("argsstring") or ""
    return "".join(words) + f"{virtual}{explicit}{type_of} {name}{arguments};".lstrip()


def _plain(node: Node | None) -> str:
    return "" if node is None else "".join(node.itertext()).replace("< ", "<").replace(" >", ">").strip()


def _about(node: Node) -> str:
    """Its comment; of an enumeration also those of its values."""
    text = ""
    for part in ("briefdescription", "detaileddescription"):
        described = node.find(part)
        if described is not None:
            text += "".join(_block(one) for one in described)
    for value in node.iterfind("enumvalue"):
        about = _in_a_line(value)
        if about:
            text += f"- `{value.findtext('name')}`: {about}\n"
    return text.rstrip() + "\n\n" if text.strip() else ""


def _block(node: Node) -> str:
    if node.tag == "para":
        inner = [one for one in node if one.tag in ("itemizedlist", "orderedlist", "programlisting", "verbatim")]
        return f"{_line(node).strip()}\n\n" + "".join(_block(one) for one in inner)
    if node.tag in ("itemizedlist", "orderedlist"):
        items = [" ".join(_line(para).strip() for para in item.iterfind("para")) for item in node.iterfind("listitem")]
        return "\n".join(f"- {item}" for item in items) + "\n\n"
    if node.tag in ("programlisting", "verbatim"):
        lines = ["".join(_code(line)) for line in node.iterfind("codeline")] or (node.text or "").splitlines()
        return "```cpp\n" + "\n".join(lines) + "\n```\n\n"
    return ""


def _code(node: Node) -> str:
    text = " " if node.tag == "sp" else node.text or ""
    return text + "".join(_code(one) + (one.tail or "") for one in node)


def _line(node: Node) -> str:
    text = _escaped(node.text or "")
    for one in node:
        if one.tag == "computeroutput":
            text += f"`{''.join(one.itertext())}`"
        elif one.tag not in ("itemizedlist", "orderedlist", "programlisting", "verbatim"):
            text += _line(one)
        text += _escaped(one.tail or "")
    return text


def _escaped(text: str) -> str:
    return _special.sub(r"\\\1", text)
