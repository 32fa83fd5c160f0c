"""The program `mimbre`, which the package carries, and `mimbre sweep`: `python -m mimbre run model.yaml`."""

import os
import sys
from pathlib import Path


def main() -> None:
    if sys.argv[1:2] == ["sweep"]:
        from .sweep_command import sweep_command

        sys.exit(sweep_command(sys.argv[2:]))
    program = Path(__file__).with_name("bin") / "mimbre"
    os.execv(program, ["mimbre", *sys.argv[1:]])


if __name__ == "__main__":
    main()
