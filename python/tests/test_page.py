"""A model as one HTML file that simulates it."""

from __future__ import annotations

import mimbre
import pytest
from conftest import made_pendulum, program


def test_a_page_is_that_of_the_program(examples, tmp_path):
    path = examples / "tutorial/pendulum.yaml"
    model = mimbre.Model.from_file(path)
    try:
        model.page(tmp_path / "page.html")
    except RuntimeError as error:
        if "make page" in str(error):
            pytest.skip("built without the solver for pages (make page)")
        raise
    program("page", path, "--quiet", "-o", tmp_path / "program.html")
    assert (tmp_path / "page.html").read_bytes() == (tmp_path / "program.html").read_bytes()


def test_a_page_needs_a_path():
    with pytest.raises(mimbre.InputError, match="path"):
        made_pendulum().page(3)  # type: ignore[arg-type]
