"""What pages have of the program and the schema: `<!-- made of: NAME -->` in a page becomes what NAME says now."""

from __future__ import annotations

import json
import re
import subprocess
import sys
from collections.abc import Callable
from typing import Any

from mkdocs.exceptions import PluginError
from model_keys import model_keys
from pages import top

_mark = re.compile(r"^<!-- made of: (.*) -->$", re.MULTILINE)


def on_page_markdown(markdown: str, page: Any, **_: Any) -> str:
    def made(mark: re.Match[str]) -> str:
        if mark[1] not in _makers:
            raise PluginError(f"{page.file.src_uri}: nothing is made of '{mark[1]}'; there are: {', '.join(_makers)}")
        return _makers[mark[1]]()

    return _mark.sub(made, markdown)


def _help(*arguments: str) -> str:
    command = [sys.executable, "-m", "mimbre", *arguments, "--help"]
    return subprocess.run(command, capture_output=True, text=True, check=True).stdout


def _commands() -> str:
    """Each command with its help, in the order of the program's own."""
    overview = _help()
    names = re.findall(r"^  (\w+) ", overview.split("Subcommands:\n")[1].split("\n\n")[0], re.MULTILINE)
    text = f"```text\n{overview.rstrip()}\n```\n"
    for name in names:
        text += f"\n## {name}\n\n```text\n{_help(name).rstrip()}\n```\n"
    return text


def _keys() -> str:
    return model_keys(json.loads((top / "schema/model.schema.json").read_text(encoding="utf-8")))


_makers: dict[str, Callable[[], str]] = {"the program's help": _commands, "the model file's schema": _keys}
