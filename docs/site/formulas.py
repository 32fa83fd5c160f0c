"""Formulas become HTML while the site is made, by KaTeX: pages need no script for them, and a wrong one fails."""

from __future__ import annotations

import json
import re
import subprocess
from typing import Any

from mkdocs.exceptions import PluginError
from pages import node

_block = re.compile(r"^```math\n(.*?)^```$", re.DOTALL | re.MULTILINE)
_script = """
const katex = require("katex");
const formulas = JSON.parse(require("fs").readFileSync(0, "utf8"));
try {
  const made = formulas.map((formula) => katex.renderToString(formula, {displayMode: true, strict: "error"}));
  process.stdout.write(JSON.stringify(made));
} catch (error) {
  process.stderr.write(error.message);
  process.exit(1);
}
"""


def on_page_markdown(markdown: str, page: Any, **_: Any) -> str:
    formulas = _block.findall(markdown)
    if not formulas:
        return markdown
    done = subprocess.run(
        ["node", "-e", _script], input=json.dumps(formulas), capture_output=True, text=True, check=False, cwd=node
    )
    if done.returncode != 0:
        raise PluginError(f"{page.file.src_uri}: a formula is wrong: {done.stderr}")
    made = iter(json.loads(done.stdout))
    return _block.sub(lambda _: f'<div class="formula">{next(made)}</div>', markdown)
