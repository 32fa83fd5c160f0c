"""Makes the pages that simulate, in the folder that is given, where the package has the solver for them (make page)."""

from __future__ import annotations

import json
import sys
from pathlib import Path

import mimbre

top = Path(__file__).resolve().parents[2]

#: By the names of their pages; the first is the one that the README's picture leads to.
models = {
    "iltis": "iltis/drive.yaml",
    "suspension": "iltis/suspension.yaml",
    "slider-crank": "slider-crank/slider-crank.yaml",
    "delta-robot": "delta-robot/model.yaml",
    "washing-machine": "washing-machine/model.yaml",
    "ball-cascade": "ball-cascade/model.yaml",
}


def main(folder: Path) -> None:
    folder.mkdir(parents=True)
    titles = {}
    for name, path in models.items():
        model = mimbre.Model.from_file(top / "examples" / path)
        try:
            model.page(folder / f"{name}.html")
        except RuntimeError as error:
            print(f"docs: no pages that simulate: {error}", file=sys.stderr)
            return
        titles[name] = model.title
    (folder / "titles.json").write_text(json.dumps(titles), encoding="utf-8")


if __name__ == "__main__":
    main(Path(sys.argv[1]))
