"""The solid arm of examples/python against what the program gives, from the same mesh."""

from __future__ import annotations

import json
import runpy
import shutil

import matplotlib as mpl
import mimbre
import numpy as np
from conftest import program, top


def test_the_example_gives_what_the_program_gives(tmp_path, monkeypatch):
    """Body, run and stress, byte by byte."""
    mpl.use("Agg")
    (tmp_path / "examples").symlink_to(top / "examples")
    monkeypatch.chdir(tmp_path)
    example = runpy.run_path(str(top / "examples/python/solid_arm.py"))

    for part in ("solid-arm", "iltis"):
        shutil.copytree(top / "examples" / part, tmp_path / "program" / part)
    monkeypatch.chdir(tmp_path / "program")
    points = {"front": "108,0,0", "rear": "-108,0,0", "ball": "0,321.4603,0", "shock": "75,248.6166,-4.6668"}
    groups = {"front": "front", "rear": "rear", "ball": "ball", "shock": "seat"}
    options = [f"--interface={name}=group:{group}" for name, group in groups.items()]
    options += [f"--point={name}={point}" for name, point in points.items()]
    options += ["--units=mm", "--material=2.1e11,0.3,7850", "--modes=2", "--free-modes=6", "--damping=0.01"]
    program("reduce", "solid-arm/arm.msh", *options, "--no-cache", "-o", "solid-arm/arm.h5")
    program("run", "solid-arm/suspension.yaml", "--set", "drop=0.2", "-q", "-o", "run.h5")
    said = json.loads(program("stress", "run.h5", "--spots", 3, "--json"))["bodies"]

    made = tmp_path / "solid-arm-study"
    assert (made / "solid-arm/arm.h5").read_bytes() == (tmp_path / "program/solid-arm/arm.h5").read_bytes()
    theirs = mimbre.Run.open("run.h5")
    for name in theirs:
        assert np.array_equal(theirs[name], example["run"][name]), name
    found = mimbre.stress(made / "run.h5", spots=3)["front_left.arm"]
    for spot, wanted in zip(found, said[0]["hot_spots"], strict=True):
        assert (spot.node, spot.von_mises, spot.time) == (wanted["node"], wanted["von_mises"], wanted["time"])
    # The history is the output that the model has: the largest of the surface, at each instant.
    assert np.allclose(example["field"].von_mises.max(axis=1), example["run"]["arm.stress"], rtol=1e-9)
