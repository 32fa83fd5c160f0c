"""What FMUs have beside their code: terminals, icons, a reference result, reports of reduced bodies."""

from __future__ import annotations

import json
import xml.etree.ElementTree as ET
from pathlib import Path
from typing import Any

import mimbre
import numpy as np
import pytest

fmpy = pytest.importorskip("fmpy")
etree = pytest.importorskip("lxml.etree")

references = "extra/org.fmi-standard.fmi-ls-ref"


def extracted(model: mimbre.Model, folder: Path, **options: Any) -> Path:
    path = model.fmu(folder / "model.fmu", name="model", **options)
    return Path(fmpy.extract(str(path), folder / "extracted"))


def schema(name: str) -> Any:
    return etree.XMLSchema(etree.parse(str(Path(fmpy.__file__).parent / "schema" / "fmi3" / name)))


@pytest.mark.parametrize("version", [2, 3])
@pytest.mark.parametrize("name", ["tutorial/pendulum.yaml", "iltis/suspension.yaml", "iltis/drive.yaml"])
@pytest.mark.filterwarnings("ignore:output .* is not in the FMU")
def test_terminals_are_valid(examples: Path, tmp_path: Path, name: str, version: Any) -> None:
    library = name == "iltis/drive.yaml"
    folder = extracted(mimbre.Model.from_file(examples / name), tmp_path, version=version, library=library)
    terminals = etree.parse(str(folder / "terminalsAndIcons" / "terminalsAndIcons.xml"))
    schema("fmi3TerminalsAndIcons.xsd").assertValid(terminals)
    variables = {v.name: v for v in fmpy.read_model_description(str(folder)).modelVariables}
    members = terminals.findall(".//TerminalMemberVariable")
    assert members
    for member in members:
        assert variables[member.get("variableName")].causality in ("input", "output", "parameter")
    for terminal in terminals.iter("Terminal"):
        names = [member.get("memberName") for member in terminal.findall("TerminalMemberVariable")]
        assert len(set(names)) == len(names)
    for shown in terminals.iter("TerminalGraphicalRepresentation"):
        for end in (".png", ".svg"):
            assert (folder / "terminalsAndIcons" / (shown.get("iconBaseName") + end)).is_file()
    icon = (folder / "terminalsAndIcons" / "icon.png").read_bytes()
    assert icon[:8] == b"\x89PNG\r\n\x1a\n"
    ET.parse(folder / "terminalsAndIcons" / "icon.svg")
    assert (folder / "model.png").is_file() == (version == 2)


@pytest.mark.parametrize("version", [2, 3])
@pytest.mark.parametrize("library", [False, True])
def test_the_experiment_is_that_of_an_importer(
    pendulum: mimbre.Model, tmp_path: Path, version: Any, library: bool
) -> None:
    folder = extracted(pendulum, tmp_path, version=version, library=library)
    experiment = ET.parse(folder / references / "reference.exp").getroot().find("Experiment")
    assert experiment is not None
    settings = experiment.find("TransientSimulation")
    stimuli, expected = experiment.find("Stimuli"), experiment.find("References")
    assert settings is not None
    assert stimuli is not None
    assert expected is not None
    signal = np.genfromtxt(folder / references / stimuli.attrib["source"], delimiter=",", names=True)
    assert list(signal.dtype.names) == ["time", "torque"]
    reference = fmpy.util.read_csv(str(folder / references / expected.attrib["source"]))
    step = float(settings.attrib["stepSize"])
    found = fmpy.simulate_fmu(
        str(folder),
        start_time=float(settings.attrib["startTime"]),
        stop_time=float(settings.attrib["stopTime"]),
        step_size=step,
        output_interval=step,
        input=signal,
    )
    assert len(reference) == 101
    for name in reference.dtype.names[1:]:
        assert np.abs(found[name] - reference[name]).max() < 1e-10
    assert np.ptp(reference["angle"]) > 0.01


def test_the_manifest_lists_files_that_are_there(examples: Path, tmp_path: Path) -> None:
    model = mimbre.Model.from_file(examples / "iltis/suspension.yaml")
    folder = extracted(model, tmp_path)
    root = ET.parse(folder / references / "fmi-ls-manifest.xml").getroot()
    assert root.tag == "fmiReferences"
    space = "{http://fmi-standard.org/fmi-ls-manifest}"
    assert root.attrib[space + "fmi-ls-name"] == "org.fmi-standard.fmi-ls-ref"
    assert root.attrib[space + "fmi-ls-version"]
    assert root.attrib[space + "fmi-ls-description"]
    listed = {(folder / references / related.attrib["source"]).resolve() for related in root}
    assert all(path.is_file() for path in listed)
    extra = {path.resolve() for path in (folder / "extra").rglob("*") if path.is_file()}
    assert extra - listed == {(folder / references / "fmi-ls-manifest.xml").resolve()}
    roles = {related.attrib["role"] for related in root}
    assert roles == {"experiment/smoke-test", "result", "report", "document"}


@pytest.mark.filterwarnings("ignore:output .* is not in the FMU")
def test_reduced_bodies_are_reported(examples: Path, tmp_path: Path) -> None:
    model = mimbre.Model.from_file(examples / "solid-arm/suspension.yaml")
    report = json.loads((extracted(model, tmp_path) / "extra/org.mimbre/reduced-bodies.json").read_text())
    bodies = {body["name"].split(".")[-1]: body for body in report["reduced_bodies"]}
    for body in bodies.values():
        assert body["modes"] == len(body["frequencies_Hz"]) > 0
    # Bodies of bars have no report; the arm's is that of its file.
    assert bodies["link"]["passed"] is None
    assert bodies["link"]["checks"] == []
    reduced = mimbre.ReducedBody.open(examples / "solid-arm/arm.h5")
    expected = [(check.name, check.passed, check.detail) for check in reduced.checks]
    assert [(c["name"], c["passed"], c["detail"]) for c in bodies["arm"]["checks"]] == expected
    assert bodies["arm"]["passed"] is True
    assert len(expected) > 3


def test_a_model_without_reduced_bodies_has_no_report(pendulum: mimbre.Model, tmp_path: Path) -> None:
    assert not (extracted(pendulum, tmp_path) / "extra/org.mimbre").exists()
