"""The models of mimbre's gallery, which the package carries: `python -m mimbre.examples`.

python -m mimbre.examples                      lists them
python -m mimbre.examples pendulum/flexible    runs one and opens its page, flexible.html
"""

from __future__ import annotations

import argparse
import re
import sys
import webbrowser
from collections.abc import Sequence
from pathlib import Path

from ._core import did_you_mean
from .errors import InputError, SimulationError, UnknownName
from .model import Model

_folder = Path(__file__).with_name("models")
_title = re.compile(r"^title: *(.*)$", re.MULTILINE)
_runs = re.compile(r"^simulation:", re.MULTILINE)  # others are parts that these include


def titles() -> dict[str, str]:
    """Each example's name with its title, in a line."""
    found = {}
    for file in sorted(_folder.glob("*/*.yaml")):
        text = file.read_text(encoding="utf-8")
        title = _title.search(text)
        if title and _runs.search(text):
            found[file.relative_to(_folder).with_suffix("").as_posix()] = title[1]
    return found


def path(name: str) -> Path:
    """The model file of an example, for `mimbre.Model.from_file`."""
    names = list(titles())
    if name not in names:
        raise UnknownName(f"there is no example '{name}'{did_you_mean(name, names)}; there are: {', '.join(names)}")
    return _folder / f"{name}.yaml"


def main(arguments: Sequence[str] | None = None) -> int:
    parser = argparse.ArgumentParser(
        prog="python -m mimbre.examples", description="Lists the examples, or runs one and opens its page."
    )
    parser.add_argument("name", nargs="?", help="such as pendulum/flexible; without it the examples are listed")
    parser.add_argument("-o", "--output", metavar="PAGE.html", help="the page; by default the model's name here")
    parser.add_argument("--until", type=float, metavar="T", help="end in s, instead of the example's")
    parser.add_argument("--no-open", action="store_true", help="do not open the page in a browser")
    given = parser.parse_args(arguments)
    if given.name is None:
        found = titles()
        width = max(map(len, found), default=0)
        for name, title in found.items():
            print(f"{name:{width}}  {title}")
        return 0
    try:
        file = path(given.name)
        page = Path(given.output or f"{file.stem}.html")
        run = Model.from_file(file).run(until=given.until)
        run.report(page)
    except InputError as error:
        print(f"mimbre.examples: {error}", file=sys.stderr)
        return 1
    except SimulationError as error:
        print(f"mimbre.examples: {error}", file=sys.stderr)
        return 3
    print(f"Ran {file} to t = {run.time[-1]:.6g} s. Its page: {page}")
    if not given.no_open:
        webbrowser.open(page.absolute().as_uri())
    return 0


if __name__ == "__main__":
    sys.exit(main())
