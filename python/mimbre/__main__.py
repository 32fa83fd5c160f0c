"""The program `mimbre`, which the package carries: `python -m mimbre run model.yaml`."""

import os
import sys
from pathlib import Path


def main() -> None:
    program = Path(__file__).with_name("bin") / "mimbre"
    os.execv(program, ["mimbre", *sys.argv[1:]])


if __name__ == "__main__":
    main()
