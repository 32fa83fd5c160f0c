"""The package as a whole: types, style, what it says of itself."""

from __future__ import annotations

import importlib.metadata
import json
import os
import re
import subprocess
import sys

import jupytext
import mimbre
import nbclient
import pytest
from conftest import program, top

PYTHON = (
    "python",
    "examples/python",
    "bench/python",
    "docs/site",
    "scripts/check-words",
    "scripts/python-words",
    "scripts/wheel-licences",
)


def passes(*command: str) -> None:
    done = subprocess.run([sys.executable, *command], capture_output=True, text=True, check=False, cwd=top)
    assert done.returncode == 0, done.stdout + done.stderr


@pytest.mark.skipif(sys.version_info < (3, 11), reason="the last NumPy and SciPy for Python 3.10 have other types")
def test_types_are_right():
    """In the strict sense of mypy, with the stubs as they are installed."""
    passes("-m", "mypy", "-p", "mimbre")
    passes("-m", "mypy", "examples/python", "bench/python", "docs/site", "python/tests/typed_use.py")


def test_style_is_kept():
    passes("-m", "ruff", "check", *PYTHON)
    passes("-m", "ruff", "format", "--check", "--diff", *PYTHON)


def test_the_words_are_those_of_the_schema():
    passes("scripts/python-words", "--check")


def test_versions_agree():
    """All with that of CMakeLists.txt, of which the package's own is made."""
    (version,) = re.findall(r"project\(mimbre VERSION ([0-9.]+)", (top / "CMakeLists.txt").read_text(encoding="utf-8"))
    assert mimbre.__version__ == importlib.metadata.version("mimbre") == version
    assert program("--version").split() == ["mimbre", version]
    assert f"\nversion: {version}\n" in (top / "CITATION.cff").read_text(encoding="utf-8")
    changes = re.findall(r"^## \[(.*?)\]", (top / "CHANGELOG.md").read_text(encoding="utf-8"), re.MULTILINE)
    assert changes[0] == version
    for folder in ("web", "docs/site"):
        lock = json.loads((top / folder / "package-lock.json").read_text(encoding="utf-8"))
        package = json.loads((top / folder / "package.json").read_text(encoding="utf-8"))
        assert package["version"] == lock["version"] == lock["packages"][""]["version"] == version, folder


examples = sorted((top / "examples/python").glob("*.py"))
notebooks = [path for path in examples if "# %%" in path.read_text(encoding="utf-8")]


#: What notebooks must have found.
found = {
    "car.py": [
        r"\d\.\d\d Hz, damping ratio .*: pitch",
        r"bounce",
        r"roll",
        r"(?s)(wheel hop.*){4}",
        r"understeer gradient 0\.002[789]",
        r"40 m/s: sideslip .*grows: False",
    ],
    "arm_modes.py": [
        r"4\.9 Hz, .*'shoulder\.gear' 44 %",
        r"lowest: 4\.8\d Hz, .* elbow 0\.00 rad",
        r"highest: 9\.\d\d Hz",
    ],
    "learning.py": ["4 of 4 stand"],
    "optimising.py": [r"k = 12.3\d", r"c = 0.21\d", r"without noise: off by \d.\de-(0[89]|1\d)", "is better: True"],
    "robot_arm.py": [r"tip differs by 0.0e\+00 m"],
    "wind_turbine.py": [r"0\.65\d Hz at 2 rpm, 0\.72\d Hz at 14 rpm: blades collective", "blades backward"],
    "solid_arm.py": [r"node \d+ at .* MPa"],
}


@pytest.mark.parametrize("name", [path.name for path in notebooks])
def test_a_notebook_runs(name, tmp_path):
    """In a kernel, every cell of it."""
    (tmp_path / "examples").symlink_to(top / "examples")
    notebook = jupytext.read(top / "examples/python" / name)
    assert [cell.cell_type for cell in notebook.cells].count("markdown") >= 2
    client = nbclient.NotebookClient(notebook, timeout=300, resources={"metadata": {"path": str(tmp_path)}})
    client.execute()
    shown = [output for cell in notebook.cells for output in cell.get("outputs", [])]
    assert any("image/png" in output.get("data", {}) for output in shown)
    text = "".join(output.text for output in shown if output.output_type == "stream")
    for wanted in found[name]:
        assert re.search(wanted, text), text


@pytest.mark.parametrize("name", [path.name for path in examples if path not in notebooks])
def test_an_example_runs(name, tmp_path):
    """In a folder with what it reads, to which it may write."""
    (tmp_path / "examples").symlink_to(top / "examples")
    done = subprocess.run(
        [sys.executable, top / "examples/python" / name],
        capture_output=True,
        text=True,
        check=False,
        cwd=tmp_path,
        env={**os.environ, "MPLBACKEND": "Agg"},
    )
    assert done.returncode == 0, done.stderr
    assert done.stdout


def test_code_of_the_documentation_runs(tmp_path, monkeypatch):
    """What README.md and docs/python.md show of models and runs."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("MPLBACKEND", "Agg")
    (tmp_path / "examples").symlink_to(top / "examples")
    readme = (top / "README.md").read_text(encoding="utf-8").split("## From Python")[1].split("## From C++")[0]
    names: dict[str, object] = {}
    for code in re.findall(r"```python\n(.*?)```", readme, re.DOTALL):
        exec(code, names)
    docs = (top / "docs/python.md").read_text(encoding="utf-8")
    m = mimbre.ModelBuilder()
    m.add_body("bar", mass=0.6, com=[0, 0, -0.5], inertia=[0.1, 0.1, 0.1])
    m.add_body("frame", mass=10, com=[0, 0, 0], inertia=[1, 1, 1])
    m.add_joint("hinge", type="revolute", between=["ground", "bar"], at=[0, 0, 0], axis=[0, 1, 0])
    m.add_input("torque", 0.0, range=[-1000, 1000])
    m.add_actuator("motor", joint="hinge", torque="torque")
    m.add_output("angle", joint="hinge")
    m.add_output("rate", joint_velocity="hinge")
    monkeypatch.chdir(top / "examples/solid-arm")
    blocks = [code for code in re.findall(r"```python\n(.*?)```", docs, re.DOTALL) if "from_file" not in code]
    assert len(blocks) == 6
    for code in blocks:
        exec(code, {"mimbre": mimbre, "m": m, "model": m.compile()})
