"""The examples that the package carries: `python -m mimbre.examples`."""

from __future__ import annotations

import math
import subprocess
import sys

import mimbre
import numpy as np
import pytest
from conftest import top
from mimbre import examples


def command(*arguments: str, cwd) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, "-m", "mimbre.examples", *arguments], capture_output=True, text=True, check=False, cwd=cwd
    )


def test_every_model_of_the_clone_is_carried_as_it_is(tmp_path):
    """All that can be run, each with a line; with the files that it includes."""
    files = {path.relative_to(top / "examples") for path in (top / "examples").glob("*/*.yaml")}
    carried = examples.path("pendulum/flexible").parents[1]
    for file in files:
        assert (carried / file).read_bytes() == (top / "examples" / file).read_bytes(), file
    runnable = {f.with_suffix("").as_posix() for f in files if "\nsimulation:" in (top / "examples" / f).read_text()}
    assert set(examples.titles()) == runnable
    listed = command(cwd=tmp_path)
    assert listed.returncode == 0, listed.stderr
    lines = dict(line.split(maxsplit=1) for line in listed.stdout.splitlines())
    assert lines == examples.titles()
    assert lines["iltis/vehicle"] == "Bombardier Iltis"


def test_every_example_can_be_read():
    for name in examples.titles():
        assert mimbre.Model.from_file(examples.path(name)).outputs, name


def test_an_example_runs_and_is_shown(tmp_path):
    """To the same channels as the model of the clone; the page is a whole one."""
    done = command("pendulum/flexible", "--until", "0.1", "--no-open", cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    assert "to t = 0.1 s" in done.stdout
    page = (tmp_path / "flexible.html").read_text(encoding="utf-8")
    assert page.startswith("<!doctype html>") or page.startswith("<!DOCTYPE html>")
    assert "Flexible pendulum" in page


def test_the_page_is_opened(tmp_path, monkeypatch):
    opened = []
    monkeypatch.setattr("webbrowser.open", opened.append)
    page = tmp_path / "page.html"
    assert examples.main(["tutorial/pendulum", "--until", "0.05", "-o", str(page)]) == 0
    assert opened == [page.as_uri()]
    assert page.exists()


def test_unknown_names_and_impossible_ends_are_refused(tmp_path):
    done = command("pendulum/flexibel", cwd=tmp_path)
    assert done.returncode == 1
    assert "(did you mean 'pendulum/flexible'?)" in done.stderr
    done = command("pendulum/flexible", "--until", "-1", cwd=tmp_path)
    assert done.returncode == 1
    assert not list(tmp_path.iterdir())
    with pytest.raises(mimbre.UnknownName, match="there is no example 'x'"):
        examples.path("x")


def test_an_example_keeps_its_physics():
    """A rod that is let go from the horizontal is at its lowest after a quarter of its period, K(1/√2)/ω₀ with ω₀² =
    3g/(2L)."""
    run = mimbre.Model.from_file(examples.path("tutorial/pendulum")).run(until=1, step=0.001)
    quarter = 1.8540746773013719 / math.sqrt(1.5 * 9.81)
    assert np.interp(quarter, run.time, np.abs(run["angle"])) == pytest.approx(math.pi / 2, abs=1e-4)
