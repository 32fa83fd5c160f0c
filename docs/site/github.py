"""Pages are written as GitHub shows them. Here what it reads and Python's Markdown does not becomes what both mean."""

from __future__ import annotations

import posixpath
import re
from pathlib import Path
from typing import Any

from mkdocs.exceptions import PluginError
from pages import shown, top
from pymdownx.slugs import slugify

_fence = re.compile(r"^(`{3,})([^\s`]*)[^`]*$")
_item = re.compile(r"(?:[-*]|1\.) ")
_link = re.compile(r"(?<!!)\[([^\]\[]*)\]\(([^)#\s]+)(#[^)\s]*)?\)")
_comment = re.compile(r"<!--.*?-->", re.DOTALL)
_tabs = {"sh": "Command line", "yaml": "Model file", "python": "Python"}
_slug = slugify(case="lower")


def on_page_markdown(markdown: str, page: Any, **_: Any) -> str:
    """Outside of code: links and lists; then code in several languages in a row becomes tabs."""
    parts = _parts(markdown)
    for k, (language, text) in enumerate(parts):
        if language is None:
            text = _comment.sub("", text)  # one at the beginning of a line would end its paragraph
            parts[k] = (None, _lists(_link.sub(lambda link: _linked(link, page.file.src_uri), text)))
    return "".join(_tabbed(parts))


def _parts(markdown: str) -> list[tuple[str | None, str]]:
    """Text and blocks of code in turn; of code its language."""
    parts: list[tuple[str | None, str]] = [(None, "")]
    end = ""
    for line in markdown.splitlines(keepends=True):
        fence = _fence.match(line.rstrip())
        if not end and fence:
            end = fence[1]
            parts.append((fence[2], f"{fence[1]}{fence[2]}\n"))  # without words that are for tests
            continue
        language, text = parts[-1]
        parts[-1] = (language, text + line)
        if end and line.strip() == end:
            end = ""
            parts.append((None, ""))
    return parts


def _linked(link: re.Match[str], page: str) -> str:
    """A link to a folder is one to its README, one to an example's file to where its page shows it, one to a public
    header to its page; what the site does not have stays as text. A page that is called by its file's name is called by
    its title."""
    text, target, anchor = link[1], link[2], link[3] or ""
    if re.match(r"\w+:", target):
        return link[0]
    folder = posixpath.dirname(page)
    goal = posixpath.normpath(posixpath.join(folder, target))
    path = top / goal
    if not path.exists():
        raise PluginError(f"{page}: there is no {goal}, to which '{text}' is a link")
    if path.is_dir():
        goal = "docs/gallery.md" if goal == "examples" else f"{goal}/README.md"
        if not (top / goal).exists():
            return text
    elif goal.startswith("examples/") and path in shown(path.parent):
        anchor = "#" + _slug(path.name, "-")
        goal = f"{posixpath.dirname(goal)}/README.md"
    elif goal.startswith("include/mimbre/") and path.suffix == ".h":
        goal = goal.removesuffix(".h") + ".md"
    elif path.suffix not in (".md", ".png"):
        return text
    if text == path.name and path.suffix == ".md":
        text = _title(path)
    return f"[{text}]({posixpath.relpath(goal, folder or '.')}{anchor})"


def _title(path: Path) -> str:
    with path.open(encoding="utf-8") as lines:
        return next(line.removeprefix("# ").strip() for line in lines if line.startswith("# "))


def _lists(text: str) -> str:
    """With an empty line before each list, which GitHub does not need."""
    lines: list[str] = []
    in_list = False
    for line in text.splitlines(keepends=True):
        item = _item.match(line) is not None
        if item and not in_list and lines and lines[-1].strip():
            lines.append("\n")
        in_list = item or (in_list and (not line.strip() or line.startswith(" ") or bool(lines[-1].strip())))
        lines.append(line)
    return "".join(lines)


def _tabbed(parts: list[tuple[str | None, str]]) -> list[str]:
    """Blocks with nothing between them, in the command line's or the model file's language and in Python, are the same
    said twice: tabs. A block without a language is what the one before it prints."""
    made: list[str] = []
    k = 0
    while k < len(parts):
        group, after = _group(parts, k)
        names = [name for name, _ in group]
        if len(set(names)) > 1 and "Python" in names:
            for name, text in group:
                made.append(f'=== "{name}"\n\n' + re.sub(r"^(?=.)", "    ", text, flags=re.MULTILINE) + "\n")
            k = after
        else:
            made.append(parts[k][1])
            k += 1
    return made


def _group(parts: list[tuple[str | None, str]], first: int) -> tuple[list[tuple[str, str]], int]:
    """The tabs that begin with a part, and the part behind them."""
    group: list[tuple[str, str]] = []
    k = first
    while k < len(parts):
        language, text = parts[k]
        if language is None and (text.strip() or not group):
            break
        if language in _tabs:
            group.append((_tabs[language], text))
        elif language == "" and group:
            group[-1] = (group[-1][0], group[-1][1] + "\n" + text)
        elif language is not None:
            break
        k += 1
    return group, k
