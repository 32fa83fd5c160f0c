"""The pages of docs/ say what their Python does and prints."""

from __future__ import annotations

import contextlib
import inspect
import io
import re
import shutil

import mimbre
import pytest
from conftest import top

BLOCK = re.compile(r"^```python\n(.*?)^```$(?:\n\n```\n(.*?)^```$)?", re.DOTALL | re.MULTILINE)


def blocks(page: str) -> list[tuple[str, str]]:
    """The page's code in its order, each with what it is said to print, or nothing."""
    return BLOCK.findall((top / "docs" / page).read_text(encoding="utf-8"))


@pytest.fixture
def quiet(monkeypatch, tmp_path):
    """In a folder of its own, without windows."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("MPLBACKEND", "Agg")
    return tmp_path


def run_blocks(page: str, names: dict[str, object]) -> int:
    """Runs a page as one program; how many blocks have printed what is shown."""
    shown = 0
    for code, said in blocks(page):
        printed = io.StringIO()
        with contextlib.redirect_stdout(printed):
            exec(compile(code, page, "exec"), names)
        assert printed.getvalue() == said, code
        shown += bool(said)
    return shown


def test_the_tutorial(quiet):
    shutil.copytree(top / "examples/tutorial", quiet, dirs_exist_ok=True)
    names: dict[str, object] = {}
    assert run_blocks("tutorial.md", names) == 11
    # What is built in Python is what the files say, to the bit.
    for name in ("pendulum", "flexible"):
        file, built = mimbre.Model.from_file(f"{name}.yaml").run(), names[name].run()
        assert list(file) == list(built)
        assert all((file[channel] == built[channel]).all() for channel in file)


def test_the_cookbook(quiet):
    assert run_blocks("cookbook.md", {}) == 25


def test_the_gallery(quiet):
    """Its reports are made, of all examples."""
    (quiet / "examples").symlink_to(top / "examples")
    assert run_blocks("gallery.md", {}) == 0
    page = (top / "docs/gallery.md").read_text(encoding="utf-8")
    for folder in (top / "examples").iterdir():
        assert f"(../examples/{folder.name})" in page


@pytest.mark.filterwarnings("ignore:output .* is not in the FMU")
def test_the_page_of_fmus(quiet):
    pytest.importorskip("fmpy")
    (quiet / "examples").symlink_to(top / "examples")
    assert run_blocks("fmu.md", {}) == 0
    assert (quiet / "pendulum.fmu").is_file()


def test_coming_from_other_programs(quiet):
    (quiet / "examples").symlink_to(top / "examples")
    names: dict[str, object] = {}
    assert run_blocks("coming-from.md", names) == 5
    # The file says what the code beside it builds.
    page = (top / "docs/coming-from.md").read_text(encoding="utf-8")
    file = mimbre.Model.from_text(re.findall(r"```yaml\n(.*?)```", page, re.DOTALL)[0]).run()
    m = re.findall(r"```python\n(import mimbre\n.*?)```", page, re.DOTALL)[0]
    with contextlib.redirect_stdout(io.StringIO()):
        exec(m, names)
    built = names["run"]
    assert all((file[channel] == built[channel]).all() for channel in file)
    # What it names is there.
    for owner, name in re.findall(r"`(mimbre|m|run|sim|model)\.(\w+)", page):
        kinds = {"m": mimbre.ModelBuilder, "run": mimbre.Run, "sim": mimbre.Simulation, "model": mimbre.Model}
        assert hasattr(kinds.get(owner, mimbre), name), f"{owner}.{name}"


def test_the_reference_has_all_names():
    page = (top / "docs/python-reference.md").read_text(encoding="utf-8")
    named = set(re.findall(r"^::: mimbre\.(\w+)$", page, re.MULTILINE))
    assert named == set(mimbre.__all__)


@pytest.mark.parametrize("name", mimbre.__all__)
def test_a_name_says_what_it_is(name):
    """All that is public of it has a text; code in the texts is code."""
    thing = getattr(mimbre, name)
    if isinstance(thing, str):  # a constant, whose text stands in the source
        return
    members = {name: thing}
    if isinstance(thing, type):
        own = [base for base in thing.__mro__ if base.__module__.startswith("mimbre")]
        members.update({k: v for base in own for k, v in vars(base).items() if k[0] != "_"})
    for member, value in members.items():
        if not (isinstance(value, property | classmethod | type) or callable(value)):
            continue
        text = inspect.getdoc(value) or ""
        assert text, f"{name}: {member} says nothing"
        for code in re.findall(r"```python\n(.*?)```", text, re.DOTALL):
            compile(inspect.cleandoc(code), member, "exec")
