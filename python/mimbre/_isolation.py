"""What the package asks of its compiled module for the whole process, before anything else uses it.

Results, bodies and meshes are first read by the program that the package carries: a damaged file gives a message and
does not end the interpreter. The BLAS below works in one thread where nobody else has loaded it (NumPy's is another,
but for those of some distributions): then a reduction has the program's bits."""

from pathlib import Path

import numpy as numpy  # it loads its BLAS

from . import _processor as _processor  # before the compiled module, which may not run here


def _blas_is_loaded() -> bool:
    try:
        maps = Path("/proc/self/maps").read_text(encoding="utf-8", errors="replace")
    except OSError:
        return True
    return any(f"/lib{name}.so" in maps for name in ("openblas", "blas"))


_shared = _blas_is_loaded()

from . import _core  # noqa: E402

if not _shared:
    _core.use_one_blas_thread()
_program = Path(__file__).with_name("bin") / "mimbre"
if _program.exists():
    _core.isolate_reading(str(_program))
