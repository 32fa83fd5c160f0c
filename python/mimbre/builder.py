"""Models in code, by names, in the words of model files."""

from __future__ import annotations

import copy
import os
import re
import sys
import tempfile
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from . import _checks, _yaml, laws
from ._yaml import Place
from .errors import InputError
from .model import Model
from .reduction import ReducedBody

if TYPE_CHECKING:
    from typing import Literal

    from typing_extensions import Unpack

    from . import words

_file = "<built in Python>"
_order = (
    "parameters",
    "require",
    "materials",
    "sections",
    "bodies",
    "frames",
    "joints",
    "constraints",
    "springs",
    "bushings",
    "gas_springs",
    "hydraulic_dampers",
    "frictions",
    "stops",
    "torsion_springs",
    "cables",
    "surfaces",
    "contacts",
    "loads",
    "roads",
    "tyres",
    "inputs",
    "signals",
    "events",
    "actuators",
    "motors",
    "drags",
    "subsystems",
    "instances",
    "neglected_inertia",
    "outputs",
)
_lists = ("require", "outputs")


class Part:
    """What a model and a subsystem can both have. A thing is added with its name and the keys that it has in a model
    file (docs/model-keys.md), as arguments: numbers (SI), texts with units or expressions, lists, arrays, dictionaries.
    Things may name each other in any order; mistakes in them are reported when the model is compiled, all at
    once, with the line of Python that added the thing. A name that is used twice raises InputError at once."""

    def __init__(self) -> None:
        self._things: dict[str, dict[str, tuple[object, Place]]] = {}

    def add_body(self, name: str, /, **keys: Unpack[words.Body]) -> None:
        """A rigid or a flexible body.

        Args:
            name: by which others name it.
            **keys: of `body` in the model file. Rigid: mass (kg), com (3, m), inertia about it (3 or 6, kg m²).
                Flexible: `reduced`, a ReducedBody or a file of one, or `flexible`, beams; with `frame`, where its
                tangent frame lies.

        Example:
            ```python
            m.add_body("bar", mass="600 g", com=[0.5, 0, 0], inertia=[1e-5, 0.05, 0.05])
            m.add_body("arm", reduced=mimbre.ReducedBody.open("arm.h5"), frame={"at": [0, 0, 0]})
            ```
        """
        self._add("bodies", name, keys)

    def add_frame(self, name: str, /, **keys: Unpack[words.Frame]) -> None:
        """A point with axes on a body that others can name: body, at (3, m, global), x, y, z (directions)."""
        self._add("frames", name, keys)

    def add_joint(self, name: str, /, **keys: Unpack[words.Joint]) -> None:
        """Joins two bodies, frames or nodes (BODY.NODE).

        Args:
            name: by which outputs and actuators name it.
            **keys: of `joint` in the model file: type, between (two names), at (3, m, global), axis (a direction),
                drive, spring, position and velocity (m, rad, and per s).

        Example:
            ```python
            m.add_joint("hinge", type="revolute", between=["ground", "bar"], at=[0, 0, 0], axis=[0, 1, 0])
            m.add_joint("slide", type="prismatic", between=["bar", "block"], at=[1, 0, 0], axis=[1, 0, 0],
                        drive={"position": "0.1*sin(t)"})
            ```
        """
        self._add("joints", name, keys)

    def add_constraint(self, name: str, /, **keys: Unpack[words.Constraint]) -> None:
        """Equations between bodies that are no joint: of coordinates of joints (type gear, rack, differential,
        coupling), or between two bodies (distance, on_line, on_plane, on_curve, parallel, perpendicular,
        constant_velocity, screw).

        Example:
            ```python
            m.add_constraint("reduction", type="gear", joints=["motor", "wheel"], teeth=[17, 51])
            m.add_constraint("rod", type="distance", between=["crank", "piston"], at=[[0, 0, 0.1], [0, 0, 0.4]])
            ```
        """
        self._add("constraints", name, keys)

    def add_spring(self, name: str, /, **keys: Unpack[words.Spring]) -> None:
        """Pulls two points towards each other, and damps: between, at (two points, m), elastic (a law of the length, m,
        giving N), damping (of its rate, m/s).

        Example:
            ```python
            m.add_spring("coil", between=["ground", "arm"], at=[[0, 0, 1], [0.5, 0, 0]],
                         elastic={"stiffness": "20 kN/m", "zero": 0.9}, damping=500)
            ```
        """
        self._add("springs", name, keys)

    def add_bushing(self, name: str, /, **keys: Unpack[words.Bushing]) -> None:
        """Springs and dampers in all six directions between two bodies: stiffness (of x y z rx ry rz, N/m and N m/rad,
        or 6 × 6), damping likewise, in axes of the first body."""
        self._add("bushings", name, keys)

    def add_gas_spring(self, name: str, /, **keys: Unpack[words.GasSpring]) -> None:
        """Pushes two points apart by enclosed gas: between, at, pressure (Pa) at the length (m), area (m²) and
        gas_length (m) of the column."""
        self._add("gas_springs", name, keys)

    def add_hydraulic_damper(self, name: str, /, **keys: Unpack[words.HydraulicDamper]) -> None:
        """A damper with compressible oil: between, at, damping (N s/m) and quadratic (N s²/m²) of its orifices, area
        (m²) of the piston, length (m) of the oil column in each chamber, bulk_modulus (Pa) of the oil."""
        self._add("hydraulic_dampers", name, keys)

    def add_friction(self, name: str, /, **keys: Unpack[words.Friction]) -> None:
        """Dry friction that sticks, on a joint's coordinate: its limit as `force` (N) on a length or `torque` (N m)
        about an angle, a number or an expression; static_ratio and stribeck (speed) for a higher limit at rest."""
        self._add("frictions", name, keys)

    def add_stop(self, name: str, /, **keys: Unpack[words.Stop]) -> None:
        """Stops at the ends of a joint's travel, or of the distance of two points: lower, upper (m or rad), stiffness
        (N/m or N m/rad), restitution of an impact."""
        self._add("stops", name, keys)

    def add_torsion_spring(self, name: str, /, **keys: Unpack[words.TorsionSpring]) -> None:
        """A spring with a damper on a sum of joints' coordinates, as an anti-roll bar is: `coordinates`, a list of
        {joint, factor}; stiffness (N m/rad) and rest (rad), or `elastic`, a law of the sum."""
        self._add("torsion_springs", name, keys)

    def add_cable(self, name: str, /, **keys: Unpack[words.Cable]) -> None:
        """A cable that only pulls, with one tension from end to end: over (bodies, frames or nodes), at (a place for
        each, m), axial_stiffness (E A, N), length (m; an expression: a winch) or preload (N)."""
        self._add("cables", name, keys)

    def add_motor(self, name: str, /, **keys: Unpack[words.Motor]) -> None:
        """A motor with a gear on a joint: `curve`, torque over speed, and `command` from -1 to 1; or `constant`,
        `resistance` and `voltage` of a DC motor. ratio of the gear, inertia of the rotor (kg m²)."""
        self._add("motors", name, keys)

    def add_drag(self, name: str, /, **keys: Unpack[words.Drag]) -> None:
        """Drag of the air on a point of a body, with the square of its speed against the wind: area (m²),
        coefficients (one, or three along the frame's axes), density (kg/m³), wind (3, m/s, global)."""
        self._add("drags", name, keys)

    def add_surface(self, name: str, /, **keys: Unpack[words.Surface]) -> None:
        """What spheres touch, on a body or the ground: type ("half_space", "box", "cylinder", "capsule", "sphere",
        "heights", "mesh") with its size, on, at and axes."""
        self._add("surfaces", name, keys)

    def add_contact(self, name: str, /, **keys: Unpack[words.Contact]) -> None:
        """Spheres that press and rub against surfaces, or (among=True; hundreds: swarm=True) one another: spheres (on,
        at, radius), surfaces, stiffness (N/m), restitution, friction, rolling.

        Example:
            ```python
            m.add_surface("floor", type="half_space")
            m.add_contact("bounce", spheres={"on": "ball", "radius": 0.1}, surfaces="floor", stiffness=1e5)
            ```
        """
        self._add("contacts", name, keys)

    def add_load(self, name: str, /, **keys: Unpack[words.Load]) -> None:
        """A force (3, N) or moment (3, N m) on a point, times `scale`, a function of time; global axes, or turning with
        the body as a `follower`."""
        self._add("loads", name, keys)

    def add_tyre(self, name: str, /, **keys: Unpack[words.Tyre]) -> None:
        """A vertical spring on a road: on (a body), at (3, m), road, stiffness (N/m), radius (m)."""
        self._add("tyres", name, keys)

    def add_actuator(self, name: str, /, **keys: Unpack[words.Actuator]) -> None:
        """A force (N) or torque (N m) by an expression of time, inputs, signals and outputs, on a `joint` or `between`
        two points.

        Example:
            ```python
            m.add_input("throttle", 0.0, range=[0, 1])
            m.add_actuator("motor", joint="hinge", torque="20*throttle")
            ```
        """
        self._add("actuators", name, keys)

    def add_law(
        self,
        name: str,
        /,
        *,
        force: laws.Function | None = None,
        torque: laws.Function | None = None,
        wrench: laws.Function | None = None,
        signals: Sequence[str] = (),
        states: Sequence[float] = (),
        stores: bool = False,
        **where: Unpack[laws.Where],
    ) -> None:
        """A force, or a torque about an angle, by a function, where an actuator would act: on a `joint`, or `between`
        two points; or a wrench, three forces and three torques at once, where a bushing would act, `between` two
        frames. It counts as a spring's does: against what is measured.

        A function of Python is called once a step with time, measure, rate and the `signals`; a compiled one (of
        ctypes or Numba, or an address) stands inside the iteration, with its tangents. See docs/python.md.

        Args:
            name: by which messages and channels name it.
            force: f(time in s, length in m, rate in m/s, *signals) → N; of states too, see below.
            torque: the same of an angle, rad and rad/s → N m; one of the two.
            signals: names of signals, inputs and tunable parameters whose values are further arguments.
            states: start values of what it remembers: it is given their list last, and gives (force, states).
            stores: of a compiled one: it returns the energy that it stores.
            **where: joint, or between, at, along, about.

        Raises:
            InputError: both of force and torque or none, or what is no function.

        Example:
            ```python
            m.add_law("stop", force=lambda t, x, v: min(0.0, 1e4 * (x - 0.5)), between=["ground", "bar"],
                      at=[[0, 0, 1], [1, 0, 0]])
            ```
        """
        place = _caller()
        functions = {"force": force, "torque": torque, "stiffness": wrench}
        given = [(key, function) for key, function in functions.items() if function is not None]
        if len(given) != 1:
            raise _yaml.error(place, f"law '{name}': needs 'force', 'torque' or 'wrench', one of them: a function")
        ((key, function),) = given
        try:
            made = laws.law(name, function, signals, states, stores, wrench is not None)
        except InputError as error:
            raise _yaml.error(place, f"law '{name}': {error}") from None
        self._add("actuators" if wrench is None else "bushings", name, {**where, key: made})

    def add_input(self, name: str, start: float | None = None, /, **keys: Unpack[words.InputKeys]) -> None:
        """A value from outside, which is set between steps; it starts with `start`.

        Args:
            name: by which laws, signals and runs name it.
            start: its value until it is set.
            **keys: range (least, largest), unit, hold ("constant" or "linear"), about.
        """
        self._add("inputs", name, keys, "start", start)

    def add_signal(self, name: str, value: str | float | None = None, /, **keys: Unpack[words.SignalKeys]) -> None:
        """An expression of time, inputs, signals and outputs: `every` (s) evaluates it at instants only. Or a block, by
        its keys: `m.add_signal("torque", pid="angle", setpoint="wanted", kp=200, ki=50)`."""
        self._add("signals", name, keys, "value", value)

    def add_event(self, name: str, /, **keys: Unpack[words.Event]) -> None:
        """What happens `when` an expression crosses zero, or as `crosses` has it, in a `direction`: it may `set` inputs
        and `stop` the run."""
        self._add("events", name, keys)

    def add_parameter(self, name: str, value: float | str | bool | None = None, /, **keys: Any) -> None:
        """A value that expressions may use; with `tunable=True` it can be set between steps, as an input."""
        self._add("parameters", name, keys, "value", value)

    def add_material(self, name: str, /, **keys: Unpack[words.Material]) -> None:
        """Of beams: young (Pa), poisson, density (kg/m³)."""
        self._add("materials", name, keys)

    def add_section(self, name: str, /, **keys: Unpack[words.Section]) -> None:
        """The cross section of beams: type round, tube or rectangle and its sizes (m), or area (m²), Iy, Iz, J (m⁴)."""
        self._add("sections", name, keys)

    def add_output(self, name: str, /, **keys: Unpack[words.Output]) -> None:
        """A channel with a name of its own.

        Example:
            ```python
            m.add_output("z", position="chassis", component="z")
            m.add_output("angle", joint="hinge")
            m.add_output("pin.fx", joint_force="pin", component="fx")
            ```
        """
        self._add("outputs", name, keys)

    def require(self, that: str, message: str) -> None:
        """Conditions on parameters, with the message if one is not met."""
        self._add("require", str(len(self._things.get("require", {}))), {"that": that, "message": message})

    def _add(self, section: str, name: str, keys: Mapping[str, object], alone: str = "", value: object = None) -> None:
        place = _caller()
        things = self._things.setdefault(section, {})
        what = section.removesuffix("s") if section != "bodies" else "body"
        if not isinstance(name, str) or not name:
            raise _yaml.error(place, f"{what}: its name is a text, not {_checks.described(name)}")
        if name in things:
            first = things[name][1]
            raise _yaml.error(
                place,
                f"{what} '{name}': is added twice (first in {first.file}:{first.line}); remove or rename one",
            )
        try:
            _checks.text("its name", name)
            thing = {key.removesuffix("_"): copy.deepcopy(v) for key, v in keys.items()}
            if alone and value is not None:
                thing = {alone: copy.deepcopy(value), **thing}
        except InputError as error:
            raise _yaml.error(place, f"{what}: {error}") from None
        except Exception as error:  # of objects that cannot be copied, such as modules
            raise _yaml.error(place, f"{what} '{name}': {error}") from None
        things[name] = (thing[alone] if thing.keys() == {alone} else thing, place)

    def place(
        self,
        name: str,
        subsystem: Subsystem | Callable[..., object],
        *,
        at: words.Vector | None = None,
        mirror: str | None = None,
        rotate: words.Vector | None = None,
        **parameters: Any,
    ) -> None:
        """Places a subsystem; its things are then called NAME.THING. In a subsystem this goes along with it.

        Args:
            name: of this place.
            subsystem: a Subsystem, or a function that fills one: it is called with an empty Subsystem and parameters.
            at: where its origin goes, 3, m.
            mirror: before it is turned and moved: "y" is y to −y; also "x", "z", "xy" and so on.
            rotate: rotation vector, 3, rad.
            **parameters: of the function; of a Subsystem those of its `add_parameter`.

        Raises:
            InputError: neither a Subsystem nor a function.

        Example:
            ```python
            def wheel(part, radius=0.3):
                part.add_body("hub", mass=20, com=[0, 0.7, 0], inertia=[1, 2, 1])

            m.place("left", wheel, at=[1, 0, 0], radius=0.31)
            m.place("right", wheel, at=[1, 0, 0], mirror="y")
            ```
        """
        placed: dict[str, object] = {"at": at, "mirror": mirror, "rotate": rotate}
        if isinstance(subsystem, Subsystem):
            placed["with"] = parameters or None
        elif callable(subsystem):
            part = Subsystem()
            subsystem(part, **parameters)
            subsystem = part
        else:
            raise _yaml.error(
                _caller(),
                f"instance '{name}': a Subsystem, or a function that fills one, is needed, "
                f"not {_checks.described(subsystem)}",
            )
        if subsystem is self or _stands_in(self, subsystem):
            raise _yaml.error(_caller(), f"instance '{name}': the subsystem would stand in itself")
        of = self._template(subsystem, name)
        self._add(
            "instances",
            name,
            {"of": of, **{key: value for key, value in placed.items() if value is not None}},
        )

    def _template(self, part: Subsystem, name: str) -> str:
        """The name of a template like this one, which is added where there is none."""
        templates = self._things.setdefault("subsystems", {})
        text = part._text()
        for known, (template, _) in templates.items():
            if isinstance(template, Subsystem) and (template is part or template._text() == text):
                return known
        templates[name] = (part, _caller())
        return name

    def _write_things(self, writer: _yaml.Writer, indent: int) -> None:
        for section in _order:
            things = self._things.get(section)
            if not things:
                continue
            writer.section(" " * indent + section)
            for name, (thing, place) in things.items():
                what = f"{section.removesuffix('s') if section != 'bodies' else 'body'} '{name}'"
                if isinstance(thing, Subsystem):
                    writer.section(" " * (indent + 2) + _yaml.scalar(name))
                    thing._write_things(writer, indent + 4)
                elif section in _lists:
                    named = {"name": name} if section == "outputs" else {}
                    writer.item({**named, **dict(thing)}, indent + 2, place, what)  # type: ignore[call-overload]
                else:
                    writer.add(name, thing, indent + 2, place, what)

    def _text(self) -> str:
        writer = _yaml.Writer(_told_apart)
        self._write_things(writer, 0)
        return writer.text


class Subsystem(Part):
    """A part of a model that is written once and placed several times (`place`), with its own names: inside, names
    mean its own things first, then those of what it stands in, the model's last. It has all methods of ModelBuilder
    that add things but roads; what is placed in it goes along with it."""


class ModelBuilder(Part):
    """Builds a model. A thing is added with its name and the keys that it has in a model file (docs/model-keys.md), as
    arguments: numbers (SI), texts with units or expressions, lists, arrays, dictionaries; a key that is a word of
    Python has an underscore behind it (`as_`). Things may name each other in any order; mistakes in them are reported
    by `compile`, all at once, with the line of Python that added the thing. A name that is used twice raises InputError
    at once.

    Args:
        title: what the model calls itself.
        gravity: 3, m/s²; default: [0, 0, -9.81].
        initial: "assembled" (default), or "equilibrium".

    Example:
        ```python
        m = mimbre.ModelBuilder("Pendulum")
        m.add_body("bar", mass=0.6, com=[0.5, 0, 0], inertia=[1e-5, 0.05, 0.05])
        m.add_joint("hinge", type="revolute", between=["ground", "bar"], at=[0, 0, 0], axis=[0, 1, 0])
        m.add_output("angle", joint="hinge")
        run = m.compile().run(until=5)
        ```
    """

    def __init__(
        self,
        title: str = "",
        *,
        gravity: words.Vector | None = None,
        initial: Literal["assembled", "equilibrium"] | None = None,
    ) -> None:
        super().__init__()
        self._head: dict[str, tuple[object, Place]] = {}
        for key, value in {"title": title, "gravity": gravity, "initial": initial}.items():
            if value is not None and not (isinstance(value, str) and not value):
                self._head[key] = (value, _caller())
        self._simulation: tuple[object, Place] | None = None

    def set_simulation(self, **keys: Unpack[words.Simulation]) -> None:
        """Step (s), end (s) and method of runs that do not set them: the keys of `simulation` in the model file."""
        self._simulation = (dict(keys), _caller())

    def neglect_inertia(self, body: str, /, terms: Sequence[str]) -> None:
        """Terms of a flexible body's inertia that the model does without, as `mimbre.inertia_terms` finds them; "all":
        of all flexible bodies."""
        self._add("neglected_inertia", body, {"terms": list(terms)}, "terms")

    def add_road(self, name: str, /, **keys: Unpack[words.Road]) -> None:
        """What tyres roll on: over ("distance" or "time"), points (n × 2: m or s, height in m), repeat."""
        self._add("roads", name, keys)

    # What it makes

    def compile(self) -> Model:
        """Checks everything and makes the model.

        Raises:
            InputError: with every mistake, by the lines of Python that they are in.
        """
        writer, bodies = self._written()
        own = tempfile.TemporaryDirectory(prefix="mimbre-") if bodies else None
        folder = Path(own.name) if own else Path.cwd()
        _save(bodies, folder)
        try:
            model = Model._parsed(writer.text, _file, folder, {}, own, self._laws())
        except InputError as error:
            raise type(error)(_yaml.in_python(error.diagnostics, _file, writer.places)) from None
        model._warnings = list(_yaml.in_python(model._warnings, _file, writer.places))
        return model

    def to_yaml(self, path: str | os.PathLike[str] | None = None) -> str:
        """The equivalent model file.

        Args:
            path: where it is written too, with the reduced bodies beside it.

        Returns:
            The text.

        Raises:
            InputError: the model has laws that are functions, which a file cannot hold.
        """
        laws.refuse_in_file(self._laws())
        writer, bodies = self._written()
        if path is not None:
            target = Path(_checks.path("path", path))
            _save(bodies, target.parent)
            target.write_text(writer.text, encoding="utf-8")
        return writer.text

    def _written(self) -> tuple[_yaml.Writer, dict[str, ReducedBody]]:
        bodies: dict[str, ReducedBody] = {}

        def special(value: object) -> object | None:
            """A reduced body's file, which is written beside the model's; of a law, a force that it replaces."""
            if isinstance(value, laws.Law):
                return [0] * 6 if value.between_frames else 0
            if not isinstance(value, ReducedBody):
                return None
            name = re.sub(r"[^\w.-]", "_", value.name)[:60].lstrip(".") or "body"
            file, count = f"{name}.h5", 1
            while bodies.get(file, value) is not value:
                count += 1
                file = f"{name}-{count}.h5"
            bodies[file] = value
            return file

        writer = _yaml.Writer(special)
        writer.add("mimbre", 1)
        for key, (value, place) in self._head.items():
            writer.add(key, value, place=place)
        self._write_things(writer, 0)
        if self._simulation:
            writer.add("simulation", self._simulation[0], place=self._simulation[1])
        return writer, bodies

    def _laws(self) -> list[laws.Placed]:
        """Those of the model and of the subsystems in it."""
        return _placed_laws(self, "")


def _placed_laws(part: Part, prefix: str) -> list[laws.Placed]:
    found = [(prefix, law) for law in _laws_of(part)]
    for name, (instance, _) in part._things.get("instances", {}).items():
        template = part._things["subsystems"][instance["of"]][0]  # type: ignore[index]
        if isinstance(template, Subsystem):
            found += _placed_laws(template, f"{prefix}{name}.")
    return found


def _stands_in(part: Part, outer: Part) -> bool:
    """Whether `outer` has it among the subsystems in it, or in these."""
    templates = [template for template, _ in outer._things.get("subsystems", {}).values()]
    return any(isinstance(t, Subsystem) and (t is part or _stands_in(part, t)) for t in templates)


def _laws_of(part: Part) -> list[laws.Law]:
    keys = (thing for section in ("actuators", "bushings") for thing, _ in part._things.get(section, {}).values())
    return [law for thing in keys if isinstance(thing, dict) for law in thing.values() if isinstance(law, laws.Law)]


def _told_apart(value: object) -> object | None:
    """A text for what is no plain value, equal where it is the same."""
    if isinstance(value, laws.Law):
        return value.like
    return f"{id(value)}" if isinstance(value, ReducedBody) else None


def _save(bodies: Mapping[str, ReducedBody], folder: Path) -> None:
    for file, body in bodies.items():
        body.save(folder / file)


def _caller() -> Place:
    """The line outside of this package that called it."""
    here = os.path.dirname(__file__)
    frame = sys._getframe(1)
    while frame.f_back and os.path.dirname(frame.f_code.co_filename) == here:
        frame = frame.f_back
    return Place(frame.f_code.co_filename, frame.f_lineno)
