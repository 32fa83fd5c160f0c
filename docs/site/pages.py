"""Which files of the repository are pages of the site: those that people read, in the places that they have there."""

from __future__ import annotations

import html
import json
from functools import cache
from pathlib import Path
from typing import Any

from cpp_reference import cpp_pages
from mkdocs.config.defaults import MkDocsConfig
from mkdocs.structure.files import File, Files, InclusionLevel

top = Path(__file__).resolve().parents[2]
node = top / "build/docs-node/node_modules"

_pages = (
    "README.md",
    "CHANGELOG.md",
    "CONTRIBUTING.md",
    "docs/*.md",
    "examples/*/README.md",
    "src/*/README.md",
    "web/README.md",
)
_pictures = ("docs/*.png", "docs/*.svg")
_assets = {
    "assets/katex/katex.min.css": node / "katex/dist/katex.min.css",
    "assets/iframe-worker.js": node / "iframe-worker/shim/index.js",
}
_simulated = top / "build/docs-simulated"  # by simulated.py; empty without the solver for pages
_wide = ("docs/coming-from.md",)  # whose tables take the place of the contents beside them
_languages = {".yaml": "yaml", ".py": "python", ".cpp": "cpp", ".geo": "text"}


@cache
def _headers() -> dict[str, str]:
    return cpp_pages(top / "include", top / "build/docs-cpp")


def on_config(config: MkDocsConfig) -> MkDocsConfig:
    examples = [f"examples/{folder.name}/README.md" for folder in _examples()]
    rooms = [path.relative_to(top).as_posix() for path in sorted(top.glob("src/*/README.md"))]
    for entry in config.nav or []:
        if "Examples" in entry:
            entry["Examples"] = examples
        if "C++" in entry:
            entry["C++"] = entry["C++"] + [_header_page(name) for name in _headers()]
        if "Developing" in entry:
            entry["Developing"] = entry["Developing"] + rooms
    return config


def on_files(files: Files, config: MkDocsConfig) -> Files:
    paths = [path for pattern in (*_pages, *_pictures) for path in sorted(top.glob(pattern))]
    for path in paths:
        files.append(File.generated(config, path.relative_to(top).as_posix(), abs_src_path=str(path)))
    for folder in _examples():
        files.remove(page := files.src_uris[f"examples/{folder.name}/README.md"])
        files.append(File.generated(config, page.src_uri, content=_with_files(folder)))
    for name, text in _headers().items():
        files.append(File.generated(config, _header_page(name), content=text))
    fonts = {f"assets/katex/fonts/{font.name}": font for font in (node / "katex/dist/fonts").glob("*.woff2")}
    simulated = {f"docs/simulated/{path.name}": path for path in sorted(_simulated.glob("*.html"))}
    for name, path in {**_assets, **fonts, **simulated}.items():
        files.append(File.generated(config, name, abs_src_path=str(path), inclusion=InclusionLevel.NOT_IN_NAV))
    return files


def on_page_markdown(markdown: str, page: Any, **_: Any) -> str:
    if page.file.src_uri in _wide:
        page.meta["hide"] = ["toc"]
    if page.file.src_uri == "docs/page.md":
        return markdown.replace("<!-- the pages that simulate -->", _simulated_list())
    if page.file.src_uri == "README.md" and (_simulated / "iltis.html").exists():
        picture = "](docs/report.png)]"
        return markdown.replace(f"{picture}(docs/page.md)", f"{picture}(docs/simulated/iltis.html)", 1)
    return markdown


def _simulated_list() -> str:
    """Links to the pages that simulate. They are files of their own, which Markdown's links do not know."""
    file = _simulated / "titles.json"
    titles = json.loads(file.read_text(encoding="utf-8")) if file.exists() else {}
    return "\n".join(f'- <a href="simulated/{name}.html">{html.escape(title)}</a>' for name, title in titles.items())


def _examples() -> list[Path]:
    return [page.parent for page in sorted(top.glob("examples/*/README.md"))]


def shown(folder: Path) -> list[Path]:
    """The files of an example that its page shows."""
    return [path for path in sorted(folder.iterdir()) if path.suffix in _languages]


def _header_page(name: str) -> str:
    """Of the header "mimbre/run.h"."""
    return f"include/{name.removesuffix('.h')}.md"


def _with_files(folder: Path) -> str:
    """The page of an example, with its files behind it."""
    text = (folder / "README.md").read_text(encoding="utf-8")
    for path in shown(folder):
        content = path.read_text(encoding="utf-8")
        text += f"\n## {path.name}\n\n````{_languages[path.suffix]}\n{content.rstrip()}\n````\n"
    return text
