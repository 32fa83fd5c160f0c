"""What a wheel carries and says: the part of it that needs no wheel (`make wheel` makes and tries one)."""

from __future__ import annotations

import importlib.metadata
import importlib.util
import subprocess
import sys
import tarfile
from importlib.machinery import SourceFileLoader
from pathlib import Path
from types import ModuleType

import mimbre
import pytest
from conftest import top
from mimbre import _processor

PACKAGE = Path(mimbre.__file__).parent


def script(name: str) -> ModuleType:
    """A script of the project, without running it."""
    loader = SourceFileLoader(name, str(top / "scripts" / name))
    spec = importlib.util.spec_from_loader(name, loader)
    assert spec is not None
    module = importlib.util.module_from_spec(spec)
    keep, sys.dont_write_bytecode = sys.dont_write_bytecode, True
    loader.exec_module(module)
    sys.dont_write_bytecode = keep
    return module


def test_nothing_under_the_gpl_may_be_carried():
    licences = script("wheel-licences")
    assert all(licences.allowed(licence) for licence in (licences.LIBRARIES | licences.COMPILED_IN).values())
    for licence in ("GPL-2.0-or-later", "GPL-3.0-only", "AGPL-3.0-or-later", "LGPL-2.1-or-later AND GPL-2.0-or-later"):
        assert not licences.allowed(licence), licence
    for licence in ("LGPL-2.1-or-later", "CECILL-C", "MPL-2.0", "GPL-3.0-or-later WITH GCC-exception-3.1"):
        assert licences.allowed(licence), licence
    with pytest.raises(SystemExit, match="libcholmod3 has"):
        licences.licence_of("libcholmod3", licences.LIBRARIES)
    with pytest.raises(SystemExit, match=r"is under GPL-2\.0-or-later, which the wheel must not carry"):
        licences.licence_of("libcholmod3", {"libcholmod3": "GPL-2.0-or-later"})


def test_an_old_processor_is_told_so():
    nehalem = ["fpu", "sse", "sse2", "pni", "ssse3", "cx16", "sse4_1", "sse4_2", "popcnt"]
    with pytest.raises(
        ImportError, match=r"x86-64-v3 .* this one has no abm, avx, avx2, bmi1, bmi2, f16c, fma, movbe;"
    ):
        _processor.check("x86-64-v3", nehalem)
    _processor.check("x86-64-v3", [*nehalem, *["avx", "avx2", "bmi1", "bmi2", "f16c", "fma", "abm", "movbe"]])
    _processor.check("native", nehalem)
    _processor.check("", [])


def test_schemas_come_along():
    for schema in (top / "schema").iterdir():
        assert (PACKAGE / "schema" / schema.name).read_bytes() == schema.read_bytes()


def test_metadata():
    metadata = importlib.metadata.metadata("mimbre")
    assert metadata["License-Expression"] == "BSD-3-Clause"
    assert metadata.get_all("License-File") == ["LICENSE"]
    assert metadata["Summary"]
    (start,) = importlib.metadata.distribution("mimbre").entry_points
    assert (start.group, start.name, start.value) == ("console_scripts", "mimbre", "mimbre.__main__:main")


def test_the_source_distribution_is_complete(tmp_path):
    """All that is under version control, but for what continuous integration alone needs."""
    listed = subprocess.run(["git", "ls-files", "-z"], cwd=top, capture_output=True, text=True, check=False)
    if listed.returncode != 0:
        pytest.skip("needs a clone")
    build = "import sys; from scikit_build_core.build import build_sdist; build_sdist(sys.argv[1])"
    subprocess.run([sys.executable, "-c", build, str(tmp_path)], cwd=top, check=True, capture_output=True)
    with tarfile.open(next(tmp_path.glob("*.tar.gz"))) as archive:
        inside = {name.partition("/")[2] for name in archive.getnames()}
    wanted = {
        name for name in listed.stdout.split("\0") if name and not name.startswith(".ci/") and (top / name).exists()
    }
    assert wanted - inside == set()
    assert not [name for name in inside if name.startswith(("build/", "web/node_modules/", "results/"))]
