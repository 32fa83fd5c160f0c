"""A model: read, run, written."""

from __future__ import annotations

import contextlib
import os
import tempfile
import warnings
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from . import _checks, _core, analysis, equilibria, laws, linear
from . import motion as motions
from .analysis import Verification
from .equilibria import Buckling, EquilibriumPath
from .errors import Diagnostic, InputError, Interrupted, SimulationError
from .linear import CampbellDiagram, LinearModel, Modes, Trim
from .method import Method
from .read_files import ReadFiles
from .run import Run
from .simulation import Simulation, checked_method

if TYPE_CHECKING:
    import numpy.typing as npt
    from typing_extensions import Unpack

    from .linear import Point

    #: What an input has: a value, times and values, a table's file, or a function of time that is asked at every step.
    Input = float | tuple[npt.ArrayLike, npt.ArrayLike] | str | os.PathLike[str] | Callable[[float], float]
    #: Of inputs by their names, or a table's file whose header has the names.
    Inputs = Mapping[str, Input] | str | os.PathLike[str]


class Model:
    """A compiled model: constant, so that threads and simulations may share it. `from_file` reads one, a
    `ModelBuilder` builds one. Models can be pickled, with the files that they were read from. Where one of these has
    changed since, what needs it again (other values of parameters, a copy) raises InputError.

    Example:
        ```python
        model = mimbre.Model.from_file("vehicle.yaml", stairs=0.2)
        run = model.run(until=8)
        ```
    """

    _compiled: _core.Model
    _text: str  # of the model file alone
    _folder: Path  # from which it names other files
    _own: tempfile.TemporaryDirectory[str] | None  # that folder, where only this model has it
    _laws: list[laws.Placed]  # which the text cannot say
    _warnings: list[Diagnostic]
    _read: ReadFiles  # that it names

    def __init__(self) -> None:
        raise InputError("a Model is read by Model.from_file(path) or built by a ModelBuilder; it cannot be made empty")

    @classmethod
    def _parsed(
        cls,
        text: str,
        name: str,
        folder: Path,
        parameters: dict[str, str],
        own: tempfile.TemporaryDirectory[str] | None = None,
        functions: Sequence[laws.Placed] = (),
        read: ReadFiles | None = None,
    ) -> Model:
        """The model of a text; `name` stands for the file in messages, `functions` for laws; `read`: files as another
        model was read from them."""
        compiled = _core.parse(_checks.text("model", text), name, str(folder), parameters, laws.placed(functions))
        return cls._of(compiled, text, folder, own, functions, read)

    @classmethod
    def _of(
        cls,
        compiled: _core.Model,
        text: str,
        folder: Path,
        own: tempfile.TemporaryDirectory[str] | None = None,
        functions: Sequence[laws.Placed] = (),
        read: ReadFiles | None = None,
    ) -> Model:
        model = object.__new__(cls)
        model._compiled = compiled
        model._text = text
        model._folder = folder
        model._own = own
        model._laws = list(functions)
        model._warnings = [Diagnostic(*warning) for warning in compiled.warnings]
        model._read = ReadFiles(compiled.other_files, read)
        return model

    @classmethod
    def from_file(cls, path: str | os.PathLike[str], /, **parameters: float | str | bool) -> Model:
        """Reads a model file (docs/model-file.md).

        Args:
            path: of the file.
            **parameters: of the file, by name: a number (SI), or a text as the file would have it ("5 mm", a word).

        Returns:
            The model.

        Raises:
            InputError: with every mistake that was found, and where.
        """
        file = _checks.path("path", path)
        compiled = _core.load(file, _texts(parameters))
        return cls._of(compiled, Path(file).read_bytes().decode(), Path(file).absolute().parent)

    @classmethod
    def from_text(cls, text: str, /, **parameters: float | str | bool) -> Model:
        """The model of a text.

        Args:
            text: of a model file; files that it names are found from the working directory.
            **parameters: as `from_file` takes them.

        Returns:
            The model.

        Raises:
            InputError: with every mistake that was found, and where.
        """
        return cls._parsed(_checks.text("text", text), "<text>", Path.cwd(), _texts(parameters))

    @classmethod
    def from_urdf(
        cls,
        path: str | os.PathLike[str],
        /,
        *,
        floating: bool = False,
        keep_fixed: bool = False,
        packages: Mapping[str, str | os.PathLike[str]] | None = None,
        repair: bool = False,
    ) -> Model:
        """A robot from a URDF file (docs/urdf.md); `to_yaml` gives the model file. Parts that were left out, assumed or
        repaired is among its `warnings`.

        Args:
            path: of the file.
            floating: the root link moves freely; else the ground holds it.
            keep_fixed: links on fixed joints stay bodies; else they become part of what carries them.
            packages: the folders that package://NAME means, by NAME.
            repair: masses and inertias that no matter can have become the nearest that it can, and what cannot be read
                as it is written is read as it must be meant; else a model of them is refused.

        Returns:
            The model.

        Raises:
            InputError: with every mistake that was found, and where.
        """
        file = _checks.path("path", path)
        folder = Path(file).absolute().parent
        given = {
            name: _checks.path(f"packages: {name}", place)
            for name, place in _checks.mapping("packages", packages or {}, "a folder for each name").items()
        }
        text, notes = _core.robot(file, str(folder), bool(floating), bool(keep_fixed), given, bool(repair))
        model = cls._parsed(text, str(Path(file).with_suffix(".yaml")), folder, {})
        model._warnings[:0] = [Diagnostic(*note) for note in notes]
        return model

    def _with(self, parameters: Mapping[str, float | str | bool]) -> Model:
        """The same with parameters of its file replaced, compiled anew."""
        self._read.refuse_changes()
        texts = {**self.parameters, **_texts(parameters)}
        return Model._parsed(self._text, self._compiled.file, self._folder, texts, self._own, self._laws, self._read)

    # What it is

    @property
    def title(self) -> str:
        """What the model calls itself."""
        return self._compiled.title

    @property
    def bodies(self) -> list[str]:
        """Names, in the order of the tree."""
        return self._compiled.bodies

    @property
    def joints(self) -> list[str]:
        """Names; bodies without a joint have one named BODY.floating."""
        return self._compiled.joints

    @property
    def inputs(self) -> list[str]:
        """Names of inputs and tunable parameters."""
        return self._compiled.inputs

    @property
    def outputs(self) -> list[str]:
        """Names of the outputs, in the order of the model."""
        return self._compiled.outputs

    @property
    def coordinates(self) -> int:
        """Velocity coordinates: joints' and modal amplitudes."""
        return self._compiled.coordinates

    @property
    def elastic_coordinates(self) -> int:
        """How many of the coordinates are modal amplitudes."""
        return self._compiled.elastic_coordinates

    @property
    def constraints(self) -> int:
        """Equations of cut joints and drives, redundant ones too."""
        return self._compiled.constraints

    @property
    def parameters(self) -> dict[str, str]:
        """Those of the file that were replaced, as texts."""
        return self._compiled.parameters

    @property
    def warnings(self) -> list[Diagnostic]:
        """What was suspicious while the model was read."""
        return list(self._warnings)

    def __repr__(self) -> str:
        return (
            f"<mimbre.Model {self.title!r}: {len(self.bodies)} bodies, {len(self.joints)} joints, "
            f"{self.coordinates} coordinates>"
        )

    # What it does

    def simulation(self, *, inputs: Mapping[str, float] | None = None, **method: Unpack[Method]) -> Simulation:
        """The model in motion, to be stepped.

        Args:
            inputs: what inputs and tunable parameters start with, by name, in place of the model's values; its
                equilibrium is that with them.
            **method: step and method in place of the model's, see `Method`.

        Returns:
            A simulation at its start: loops closed, initial values and, where the model wants it, equilibrium found.

        Raises:
            InputError: an option or an input that does not exist or does not fit, or no start (or no equilibrium) was
                found.
        """
        return Simulation(self, inputs=inputs, **method)

    def run(
        self,
        *,
        until: float | None = None,
        inputs: Inputs | None = None,
        progress: Callable[[float], object] | None = None,
        **method: Unpack[Method],
    ) -> Run:
        """Simulates, as `mimbre run` does, to the same bits.

        Args:
            until: the end, s; default: the model's.
            inputs: of inputs and tunable parameters, by name: a number, (times in s, values), a file with a table of
                them (CSV), or a function of time that is called before each step; or one file with a table of several
                inputs. They count from the start on, with its equilibrium. What an event sets replaces a number for
                good, a table until its next point, and a function's value until the next step.
            progress: is called now and then with the time, s.
            **method: step and method in place of the model's, see `Method`.

        Returns:
            All channels at all instants, and a summary.

        Raises:
            InputError: an option or an input that does not exist or does not fit.
            SimulationError: a step failed; `error.run` has what was computed until then.
            Interrupted: Ctrl-C; `error.run` likewise, as of what a function of an input or a law raises.

        Example:
            ```python
            run = model.run(until=2, step=0.001, inputs={"throttle": lambda t: min(t, 1)})
            ```
        """
        tables, functions = _inputs(read_inputs(inputs, self))
        finished = _core.run(
            self._compiled,
            checked_method(method),
            _checks.given("until", until),
            tables,
            functions,
            _checks.callback(progress),
        )
        run = Run(finished.results, finished.measured_json)
        raised = finished.take_raised()
        if isinstance(raised, KeyboardInterrupt):
            raise Interrupted(finished.message, run) from None
        if isinstance(raised, BaseException):
            with contextlib.suppress(AttributeError):  # of an exception that has a `run` of its own
                raised.run = run  # type: ignore[attr-defined]
            raise raised
        if finished.status != "ok":
            error = SimulationError(finished.message)
            error.run = run
            raise error
        return run

    def verify(
        self,
        *,
        until: float | None = None,
        refine: bool = True,
        progress: Callable[[float], object] | None = None,
        **method: Unpack[Method],
    ) -> Verification:
        """Runs the model in both formulations, relative and natural coordinates, and compares them, as `mimbre verify`.

        Args:
            until: the end, s; default: the model's.
            refine: at half the step too, so that an error of the step can be distinguished from a mistake.
            progress: is called with the time, s, that the run at hand has reached; there are two to six runs.
            **method: step and method but `formulation`, see `Method`.

        Returns:
            The verdict, with the differences channel by channel.

        Raises:
            InputError: an option that does not exist or does not fit.
        """
        return analysis.verify(self, until=until, refine=refine, progress=progress, **method)

    def linearise(
        self,
        *,
        at: Point = None,
        hold: Mapping[str, float] | None = None,
        find: Sequence[str] | None = None,
        body: str | None = None,
        inputs: Mapping[str, float] | None = None,
        delay_order: int = 4,
        **method: Unpack[Method],
    ) -> LinearModel:
        """The linear model about a point, as `mimbre linearise`.

        Args:
            at: "equilibrium", "steady" (the velocities of the start, kept), "start", or a time of a run in s; None: the
                equilibrium where there is one, else steady motion, else the start.
            hold: conditions of steady driving, which is then the point: speed in m/s, and of a turn to the left
                lateral_acceleration in m/s², yaw_rate in rad/s or radius in m.
            find: inputs whose values make that motion steady, one for each condition.
            body: whose speed it is; None: the first body on a floating joint.
            inputs: of inputs and tunable parameters, by name, in place of the model's start values.
            delay_order: of the rational functions that replace delays, 1 to 8.
            **method: of a run to a time, see `Method`.

        Returns:
            A, B, C, D, mass, damping, stiffness, names and units.

        Raises:
            SimulationError: the point was not found or is a singular position, or a motion moves no mass.

        Example:
            ```python
            linear = model.linearise()
            omega, gain, phase = linear.to_scipy().bode()
            ```
        """
        return linear.linearise(
            self, at=at, hold=hold, find=find, body=body, inputs=inputs, delay_order=delay_order, **method
        )

    def modes(
        self,
        *,
        at: Point = None,
        hold: Mapping[str, float] | None = None,
        find: Sequence[str] | None = None,
        body: str | None = None,
        most: int | None = None,
        solver: Literal["automatic", "dense", "sparse"] = "automatic",
        inputs: Mapping[str, float] | None = None,
        delay_order: int = 4,
        **method: Unpack[Method],
    ) -> Modes:
        """The modes about a point, as `mimbre modes`: frequencies, damping, shapes, and what each mode consists of.

        Args:
            at: see `linearise`.
            hold: see `linearise`.
            find: see `linearise`.
            body: see `linearise`.
            most: so many, of the lowest frequencies; None: all.
            solver: "dense": all modes; "sparse": the lowest ones of an equilibrium by shift and invert; "automatic":
                sparse where `most` asks for a few of a large model.
            inputs: see `linearise`.
            delay_order: see `linearise`.
            **method: of a run to a time, see `Method`.

        Returns:
            The modes, rigid ones first, then by |λ|.

        Raises:
            SimulationError: as `linearise`.

        Example:
            ```python
            print([(mode.frequency, mode.damping, mode.text) for mode in model.modes(most=10)])
            car.modes(hold={"speed": 20, "radius": 100}, find=["steering", "throttle"])  # of steady driving
            ```
        """
        return linear.modes(
            self,
            at=at,
            hold=hold,
            find=find,
            body=body,
            most=most,
            solver=solver,
            inputs=inputs,
            delay_order=delay_order,
            **method,
        )

    def buckling(
        self, *, loads: Sequence[str] = (), count: int = 3, inputs: Mapping[str, float] | None = None
    ) -> Buckling:
        """Factors of loads at which the equilibrium ceases to be stable, as `mimbre static --buckling`.

        Args:
            loads: that grow together: names, or "gravity"; none: all loads, or gravity without any.
            count: factors at most, of each sign.
            inputs: of inputs and tunable parameters, by name, in place of the model's start values.

        Returns:
            The factors, those nearest to zero first, with the shapes.

        Raises:
            SimulationError: something moves without resistance when the loads are zero, or they have no potential.

        Example:
            ```python
            critical = model.buckling(loads=["press"])[0].factor
            ```
        """
        return equilibria.buckling(self, loads=loads, count=count, inputs=inputs)

    def equilibrium_path(
        self,
        *,
        loads: Sequence[str] = (),
        start: float = 0,
        end: float = 1,
        points: int = 200,
        bifurcations: int = 1,
        inputs: Mapping[str, float] | None = None,
        progress: Callable[[float, int], object] | None = None,
    ) -> EquilibriumPath:
        """Equilibria while loads grow, around limit points and beyond buckling, as `mimbre static --path`.

        Args:
            loads: that grow together: names, or "gravity"; none: all loads, or gravity without any.
            start: factor of the loads at first.
            end: factor at last.
            points: equilibria of each branch at most.
            bifurcations: whose branches are followed, at most.
            inputs: of inputs and tunable parameters, by name, in place of the model's start values.
            progress: is called with the factor and the number of equilibria so far.

        Returns:
            The branches, with the outputs at each equilibrium, and limit points and bifurcations.

        Raises:
            SimulationError: there is no equilibrium at the first factor, or something moves there without resistance.

        Example:
            ```python
            path = model.equilibrium_path(loads=["press"], end=2)
            for branch in path.branches:
                print(branch.factors, branch["tip.z"])
            ```
        """
        return equilibria.equilibrium_path(
            self,
            loads=loads,
            start=start,
            end=end,
            points=points,
            bifurcations=bifurcations,
            inputs=inputs,
            progress=progress,
        )

    def trim(
        self,
        *,
        find: Sequence[str],
        speed: float | None = None,
        lateral_acceleration: float | None = None,
        yaw_rate: float | None = None,
        radius: float | None = None,
        body: str | None = None,
        inputs: Mapping[str, float] | None = None,
    ) -> Trim:
        """Inputs with which a vehicle goes straight on or around a circle, as `mimbre trim`.

        Args:
            find: inputs to find, as many as conditions are given.
            speed: m/s; None: that of the start.
            lateral_acceleration: m/s², to the left.
            yaw_rate: rad/s, likewise; instead of it.
            radius: m, likewise.
            body: whose speed it is; None: the first body on a floating joint.
            inputs: values of other inputs.

        Returns:
            The inputs, and the outputs of that motion.

        Raises:
            SimulationError: there is none near the start.

        Example:
            ```python
            turn = model.trim(speed=20, radius=100, find=["steering", "throttle"])
            print(turn.inputs["steering"], turn.sideslip)
            ```
        """
        return linear.trim(
            self,
            find=find,
            speed=speed,
            lateral_acceleration=lateral_acceleration,
            yaw_rate=yaw_rate,
            radius=radius,
            body=body,
            inputs=inputs,
        )

    def campbell(
        self,
        parameter: str,
        values: npt.ArrayLike,
        *,
        speed: Literal["rad/s", "rpm", "Hz"] | None = None,
        orders: Sequence[float] = (1.0,),
        at: Point = None,
        hold: Mapping[str, float] | None = None,
        find: Sequence[str] | None = None,
        body: str | None = None,
        most: int | None = None,
        inputs: Mapping[str, float] | None = None,
        delay_order: int = 4,
        **method: Unpack[Method],
    ) -> CampbellDiagram:
        """Modes followed by their shapes over a parameter of the file, an input or a held condition of steady driving,
        as `mimbre modes --over`.

        Args:
            parameter: its name; "hold.speed" is a condition of steady driving (or "speed", where the model has no
                parameter or input of that name), sought anew at each value.
            values: two or more, each larger than the one before.
            speed: the unit of the parameter where it is a speed: also critical speeds.
            orders: of the speed, whose crossings with modes are critical.
            at: see `linearise`.
            hold: see `linearise`.
            find: see `linearise`.
            body: see `linearise`.
            most: so many modes, of the lowest frequencies; None: all.
            inputs: see `linearise`.
            delay_order: see `linearise`.
            **method: of a run to a time, see `Method`.

        Returns:
            Branches with eigenvalues over the values, critical speeds, and where modes begin to grow.

        Raises:
            InputError: there is no such parameter or input.
            SimulationError: as `linearise`.

        Example:
            ```python
            diagram = model.campbell("rpm", range(0, 4001, 100), speed="rpm", at="steady")
            for branch in diagram.branches:
                print(branch.name, abs(branch.values.imag))
            locus = car.campbell("hold.speed", range(5, 41), find=["throttle"])
            ```
        """
        return linear.campbell(
            self,
            parameter,
            values,
            speed=speed,
            orders=orders,
            at=at,
            hold=hold,
            find=find,
            body=body,
            most=most,
            inputs=inputs,
            delay_order=delay_order,
            **method,
        )

    def kinematics(
        self,
        *,
        start: float = 0,
        end: float | None = None,
        steps: int = 200,
        inputs: Mapping[str, float] | None = None,
    ) -> motions.Kinematics:
        """Positions, velocities and accelerations that the drives prescribe, as `mimbre kinematics`.

        Args:
            start: s.
            end: s; default: the model's.
            steps: intervals between these.
            inputs: values of inputs and tunable parameters, by name.

        Returns:
            The motion, the mobility, redundant equations and singular positions on the way.

        Raises:
            InputError: an option does not fit, or the model cannot be assembled.
        """
        return motions.kinematics(self, start=start, end=end, steps=steps, inputs=inputs)

    def inverse_dynamics(
        self,
        motion: motions.Motion | None = None,
        *,
        smooth: float = 0,
        forces: Sequence[str] = (),
        flexible: Literal["dynamic", "quasistatic"] = "dynamic",
        step: float | None = None,
        start: float = 0,
        end: float | None = None,
        steps: int = 200,
        inputs: Mapping[str, float] | None = None,
    ) -> motions.InverseDynamics:
        """Forces along joint coordinates that make a motion, in trees and loops, as `mimbre inverse-dynamics`.

        Args:
            motion: a table's file, or times and coordinates by name; default: the motion of the drives.
            smooth: s; the smoothing spline halves motions of this period; default: none.
            forces: joint coordinates along which forces act; default: those that are prescribed.
            flexible: flexible bodies, and joints held by springs, follow by their dynamics, or are in balance at
                each instant as if they were at rest in the motion.
            step: step of `dynamic`, s; default: the model's.
            start: s, without a table.
            end: s, without a table; default: the model's.
            steps: intervals between these.
            inputs: values of inputs and tunable parameters, by name.

        Returns:
            The forces, with all channels of the motion.

        Raises:
            InputError: an option or the motion does not fit the model.
            SimulationError: the motion or the balance cannot be made; the message has the time.
        """
        return motions.inverse_dynamics(
            self,
            motion,
            smooth=smooth,
            forces=forces,
            flexible=flexible,
            step=step,
            start=start,
            end=end,
            steps=steps,
            inputs=inputs,
        )

    # Elsewhere

    def to_yaml(self, path: str | os.PathLike[str] | None = None) -> str:
        """The model file's text. A model that is read from it is the same, to the bit.

        Args:
            path: where it is written too, with bodies that only the model has beside it.

        Returns:
            The text.

        Raises:
            InputError: the model has laws that are functions or was read with other parameters, which a file lacks.
        """
        laws.refuse_in_file(self._laws)
        if self.parameters:
            replaced = ", ".join(f"{name}={value}" for name, value in self.parameters.items())
            raise InputError(
                f"to_yaml: the model was read with {replaced}, which its file does not contain; "
                "give the file and these parameters to Model.from_file instead"
            )
        if path is not None:
            target = Path(_checks.path("path", path))
            top, files = self._files()
            if target.absolute().parent != self._folder:
                if top != self._folder:
                    raise InputError(
                        f"to_yaml: the model names files outside of its folder; write it into {self._folder}"
                    )
                _write(files, target.parent)
            target.write_bytes(self._text.encode())
        return self._text

    def generate(self, folder: str | os.PathLike[str], *, name: str = "", **method: Unpack[Method]) -> Path:
        """Writes C99 that steps the model and needs no library, as `mimbre generate` (docs/generated-code.md).

        Args:
            folder: for NAME.h and NAME.c; it is made.
            name: of the files and of all that is in them; default: the model file's.
            **method: step and method in place of the model's, see `Method`.

        Returns:
            The path of the source.

        Raises:
            InputError: with all reasons why code cannot be made of the model, or the folder cannot be written.
        """
        path, left_out = _core.generate(
            self._compiled, checked_method(method), _checks.path("folder", folder), _checks.text("name", name)
        )
        _left_out(left_out, "code")
        return Path(path)

    def fmu(
        self,
        path: str | os.PathLike[str],
        *,
        version: Literal[2, 3] = 3,
        kind: Literal["cs", "me"] = "cs",
        name: str = "",
        binary_only: bool = False,
        library: bool = False,
        arrays: bool = False,
        **method: Unpack[Method],
    ) -> Path:
        """Writes an FMU, as `mimbre fmu` (docs/fmu.md): sources, and a binary for this machine where there is a C
        compiler; without one there is a warning.

        Args:
            path: of the file.
            version: of the standard, FMI 2.0 or 3.0.
            kind: "cs" for co-simulation: it makes its steps by itself; "me" for model exchange: the other program's
                solver makes the steps of independent coordinates.
            name: the model identifier; default: the model file's name.
            binary_only: without the sources.
            library: the library itself inside, in place of code for the model: for whatever a run takes, with a binary
                alone, for co-simulation. Numbers among the model file's parameters can be set before the start.
            arrays: of FMI 3: outputs that are all the components of one vector are one array, `tip` in place of tip.x,
                tip.y and tip.z.
            **method: step and method in place of the model's, see `Method`.

        Returns:
            The path.

        Raises:
            InputError: with all reasons why an FMU cannot be made of the model, or the file cannot be written.

        Example:
            ```python
            model.fmu("vehicle.fmu", version=2)
            ```
        """
        left_out, without_binary = _core.fmu(
            self._compiled,
            checked_method(method),
            _checks.path("path", path),
            _checks.whole("version", version),
            _checks.known("kind of FMU", kind, ("cs", "me")),
            _checks.text("name", name),
            _checks.flag("binary_only", binary_only),
            _checks.flag("library", library),
            _checks.flag("arrays", arrays),
        )
        _left_out(left_out, "FMU")
        if without_binary:
            warnings.warn(f"the FMU has sources alone, and no binary: {without_binary}", stacklevel=2)
        return Path(path)

    def page(self, path: str | os.PathLike[str]) -> None:
        """Writes one HTML file that simulates the model in the browser, as `mimbre page` does (docs/page.md).

        Args:
            path: of the page.

        Raises:
            InputError: the model has laws that are functions, which a page cannot call.
            RuntimeError: mimbre was built without the solver for pages; `make page` builds it.
        """
        _core.write_page(self._compiled, _checks.path("path", path))

    def _files(self) -> tuple[Path, dict[str, bytes]]:
        """A folder that has the model's and all files that it names, and these by their names from there."""
        self._read.refuse_changes()
        paths = self._read.paths
        top = Path(os.path.commonpath([self._folder, *paths]))
        return top, {str(path.relative_to(top)): path.read_bytes() for path in paths}

    def __reduce__(self) -> tuple[Any, ...]:
        top, files = self._files()
        place = str(self._folder.relative_to(top))
        return _unpickled, (self._text, self._compiled.file, self.parameters, place, files, self._laws)


def _left_out(outputs: Sequence[str], of: str) -> None:
    for output in outputs:
        warnings.warn(f"output {output} is not in the {of}", stacklevel=3)


def _write(files: Mapping[str, bytes], folder: Path) -> None:
    for name, content in files.items():
        path = folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(content)


def _unpickled(
    text: str,
    name: str,
    parameters: dict[str, str],
    place: str,
    files: dict[str, bytes],
    functions: Sequence[laws.Placed] = (),
) -> Model:
    """In another process, or on another machine, the files lie in a folder of the model's own."""
    own = tempfile.TemporaryDirectory(prefix="mimbre-")
    folder = Path(own.name, place)
    folder.mkdir(parents=True, exist_ok=True)
    _write(files, Path(own.name))
    return Model._parsed(text, name, folder, parameters, own, functions)


def _texts(parameters: Mapping[str, object]) -> dict[str, str]:
    """Parameters as a model file would have them."""
    texts = {}
    for name, value in parameters.items():
        if isinstance(value, bool):
            texts[name] = "true" if value else "false"
        elif isinstance(value, str):
            texts[name] = _checks.text(name, value)
        else:
            number = _checks.number(f"parameter {name!r}", value)
            texts[name] = str(int(number)) if isinstance(value, int | np.integer) else repr(number)
    return texts


def read_inputs(inputs: Inputs | None, model: Model) -> dict[str, Input]:
    """By names; those that lie in files are read."""

    def tables(path: str | os.PathLike[str], name: str) -> dict[str, Input]:
        read = _core.read_input_table(model._compiled, _checks.path("inputs", path), name)
        return {of: (np.array(times), np.array(values)) for of, times, values in read}

    if inputs is None:
        return {}
    if isinstance(inputs, str | os.PathLike):
        return tables(inputs, "")
    if not isinstance(inputs, Mapping):
        raise InputError(
            f"inputs: names with values are needed, as {{'throttle': 0.5}}, or a table's file, not "
            f"{_checks.described(inputs)}"
        )
    found: dict[str, Input] = {}
    for name, value in inputs.items():
        name = _checks.text("inputs", name)
        found |= tables(value, name) if isinstance(value, str | os.PathLike) else {name: value}
    return found


def _inputs(
    inputs: Mapping[str, Input],
) -> tuple[list[tuple[str, list[float], list[float]]], list[tuple[str, Any]]]:
    """Those that are tables, and those that are functions."""
    tables, functions = [], []
    for name, value in inputs.items():
        what = f"input {name!r}"
        if callable(value):
            functions.append((name, value))
        elif isinstance(value, tuple):
            if len(value) != 2:
                raise InputError(f"{what}: (times, values) are needed, not {len(value)} things")
            tables.append(
                (
                    name,
                    _checks.array(f"{what}: times", value[0]).tolist(),
                    _checks.array(f"{what}: values", value[1]).tolist(),
                )
            )
        else:
            tables.append((name, [0.0], [_checks.number(what, value)]))
    return tables, functions
