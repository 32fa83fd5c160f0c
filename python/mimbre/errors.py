"""What goes wrong, and where."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import xarray as xr

    from .run import Run


@dataclass(frozen=True)
class Diagnostic:
    """One thing that is wrong (or suspicious) in the input: where, what, and what would be right."""

    file: str
    """A model file, or the Python file that built the model; empty: no file."""
    line: int
    """From 1; 0: the file as a whole."""
    column: int
    """From 1; 0: the line as a whole."""
    message: str
    """What is wrong, and what would be right."""

    def __str__(self) -> str:
        place = [self.file] if self.file else []
        if self.line > 0:
            place += [str(number) for number in (self.line, self.column) if number > 0]
        return ": ".join([":".join(place)] * bool(place) + [self.message])


class InputError(ValueError):
    """The input is bad. Has every mistake that was found, not only the first.

    Args:
        diagnostics: the mistakes, or a text.

    Example:
        ```python
        try:
            model = mimbre.Model.from_file("vehicle.yaml")
        except mimbre.InputError as error:
            for mistake in error.diagnostics:
                print(mistake.file, mistake.line, mistake.message)
        ```
    """

    def __init__(self, diagnostics: Iterable[Diagnostic] | str) -> None:
        if isinstance(diagnostics, str):
            diagnostics = [Diagnostic("", 0, 0, diagnostics)]
        self.diagnostics: tuple[Diagnostic, ...] = tuple(diagnostics)
        """The mistakes, in the order of the files."""
        super().__init__("\n".join(map(str, self.diagnostics)))

    def __reduce__(self) -> tuple[type[InputError], tuple[tuple[Diagnostic, ...]]]:
        return type(self), (self.diagnostics,)


class UnknownName(InputError, KeyError):
    """There is nothing of that name. The message lists the names there are, and the nearest."""

    __str__ = ValueError.__str__  # a KeyError would put quotes around it


class SimulationError(RuntimeError):
    """The computation failed, though the input was good, as a step that does not converge."""

    run: Run | None = None
    """What was computed until then, where a run failed."""


class Interrupted(KeyboardInterrupt):
    """Ctrl-C stopped a run."""

    def __init__(self, message: str, run: Run) -> None:
        super().__init__(message)
        self.run = run
        """What was computed until then."""

    def __reduce__(self) -> tuple[type[Interrupted], tuple[str, Run]]:
        return type(self), (str(self), self.run)


class SweepInterrupted(KeyboardInterrupt):
    """Ctrl-C stopped a sweep."""

    def __init__(self, message: str, data: xr.Dataset) -> None:
        super().__init__(message)
        self.data = data
        """What was done until then; `status` marks rows that were not run."""

    def __reduce__(self) -> tuple[type[SweepInterrupted], tuple[str, xr.Dataset]]:
        return type(self), (str(self), self.data)


def _input_error(diagnostics: Iterable[tuple[str, int, int, str]]) -> InputError:
    return InputError([Diagnostic(*diagnostic) for diagnostic in diagnostics])


def _unknown_name(diagnostics: Iterable[tuple[str, int, int, str]]) -> UnknownName:
    return UnknownName([Diagnostic(*diagnostic) for diagnostic in diagnostics])
