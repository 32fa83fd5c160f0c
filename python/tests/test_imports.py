"""No module of the package imports itself by way of others."""

from __future__ import annotations

import ast
from graphlib import CycleError, TopologicalSorter
from pathlib import Path

import mimbre
import pytest
from conftest import top

FOLDER = top / "python/mimbre"


def imports(tree: ast.AST) -> set[str]:
    """Modules of the package that a module imports, in functions too, but for those that only type checkers read."""
    found: set[str] = set()
    for node in ast.iter_child_nodes(tree):
        if isinstance(node, ast.If) and isinstance(node.test, ast.Name) and node.test.id == "TYPE_CHECKING":
            continue
        if isinstance(node, ast.ImportFrom) and node.level == 1:
            found |= {node.module} if node.module else {name.name for name in node.names}
        found |= imports(node)
    return found


def circle(sources: dict[str, str]) -> list[str]:
    graph = {name: imports(ast.parse(text)) & set(sources) for name, text in sources.items()}
    try:
        TopologicalSorter(graph).prepare()
    except CycleError as error:
        return list(error.args[1])
    return []


def test_there_is_no_circle():
    sources = {path.stem: path.read_text(encoding="utf-8") for path in FOLDER.glob("*.py")}
    assert {path.stem for path in Path(mimbre.__file__).parent.glob("*.py")} == set(sources)
    assert circle(sources) == []


def test_what_ensembles_are_made_of_has_none_for_type_checkers_either():
    names = ("_checks", "errors", "ensemble", "history_folder", "store", "study", "table")
    sources = {name: (FOLDER / f"{name}.py").read_text(encoding="utf-8") for name in names}
    assert circle({name: text.replace("if TYPE_CHECKING:", "if True:") for name, text in sources.items()}) == []


@pytest.mark.parametrize("code", ["from .b import x", "from . import b", "def f():\n    from .b import x"])
def test_a_circle_is_found(code):
    assert set(circle({"a": code, "b": "from .a import y"})) == {"a", "b"}
    assert circle({"a": code, "b": "if TYPE_CHECKING:\n    from .a import y"}) == []
