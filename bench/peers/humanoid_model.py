"""A humanoid, Unitree's G1 with 29 joints, that falls by 20 mm onto its feet with 0.1 m/s forwards.

Every joint is held by a spring with a damper. Each foot stands on the four spheres of its URDF file.
"""

import pathlib
import re
import xml.etree.ElementTree as xml
from dataclasses import dataclass
from importlib.metadata import distribution

import numpy as np
from program import Program
from robots import bare

DROP, SPEED, GRAVITY = 0.02, 0.1, 9.81  # m, m/s, m/s²
STIFFNESS, RESTITUTION, FRICTION = 1e5, 0.3, 0.8  # N/m of each sphere
# Of Hunt and Crossley's law, s/m, in Drake. A restitution of 0.3 at the speed of the first impact would need 3.09 in
# place of 2.5: Drake's contacts are damped less there.
DISSIPATION = 2.5 / np.sqrt(2 * GRAVITY * DROP)


@dataclass(frozen=True)
class Humanoid:
    urdf: str  # without shapes
    joints: dict[str, tuple[float, float]]  # stiffness in N m/rad and damping in N m s/rad, by name
    feet: dict[str, list[np.ndarray]]  # centres of the spheres in the link's axes, by link
    radius: float
    ground: float  # height below the pelvis at the start


def g1() -> Humanoid:
    """The file, in the package example-robot-data."""
    files = distribution("example-robot-data").files or []
    path = pathlib.Path(next(file for file in files if file.name == "g1_29dof_rev_1_0.urdf").locate())
    feet: dict[str, list[np.ndarray]] = {}
    radius = 0.0
    for link in xml.parse(path).getroot().iter("link"):
        for shape in link.findall("collision"):
            sphere, origin = shape.find("geometry/sphere"), shape.find("origin")
            if sphere is not None and origin is not None:
                centre = np.array([float(word) for word in origin.get("xyz", "").split()])
                feet.setdefault(link.get("name", ""), []).append(centre)
                radius = float(sphere.get("radius", ""))
    urdf = bare(path)
    names = [joint.get("name", "") for joint in xml.fromstring(urdf).iter("joint") if joint.get("type") == "revolute"]
    lower = ("hip", "knee", "ankle", "waist")
    stiff = {name: 300.0 if any(part in name for part in lower) else 40.0 for name in names}
    joints = {name: (stiffness, stiffness / 40) for name, stiffness in stiff.items()}
    # At the start the feet's axes are those of the pelvis.
    lowest = 0.756863752422211 + max(-centre[2] for centres in feet.values() for centre in centres) + radius
    return Humanoid(urdf, joints, feet, radius, lowest + DROP)


def write_model(program: Program, robot: Humanoid) -> None:
    """The converted model without stops, with springs, ground and contacts."""
    (program.folder / "humanoid.urdf").write_text(robot.urdf)
    program.call("convert", "humanoid.urdf", "--floating", "-o", "humanoid.yaml")
    lines, section, places = [], "", {}
    body = ""
    for line in (program.folder / "humanoid.yaml").read_text().splitlines():
        if line and line[0] not in " #":
            section = line.split(":")[0]
        if section == "bodies" and re.match(r"^  \w+:$", line):
            body = line.strip(" :")
        if section == "bodies" and (at := re.search(r"frame: \{at: \[([^]]*)\]", line)):
            places[body] = np.array([float(word) for word in at[1].split(",")])
        joint = re.match(r"^  (\S+): \{type: (revolute|floating), ", line)
        if joint and joint[2] == "floating":
            line = f"{line[: line.rindex('}')]}, velocity: [{SPEED}, 0, 0, 0, 0, 0]}}"
        elif joint:
            stiffness, damping = robot.joints[joint[1]]
            line = f"{line[: line.rindex('}')]}, spring: {{stiffness: {stiffness}, damping: {damping}}}}}"
        if section not in ("stops", "frictions", "outputs"):
            lines.append(line)
    lines += ["surfaces:", f"  floor: {{type: half_space, at: [0, 0, {-robot.ground}]}}", "contacts:"]
    for link, centres in robot.feet.items():
        at = ", ".join(f"[{', '.join(map(repr, (places[link] + centre).tolist()))}]" for centre in centres)
        law = f"stiffness: {STIFFNESS}, restitution: {RESTITUTION}, friction: {FRICTION}"
        lines.append(
            f"  {link}: {{spheres: {{on: {link}, at: [{at}], radius: {robot.radius}}}, surfaces: floor, {law}}}"
        )
    lines.append("outputs:")
    lines += [f"  - {{name: {axis}, position: pelvis, at: [0, 0, 0], component: {axis}}}" for axis in "xyz"]
    lines += [f"  - {{name: depth.{link}, contact_depth: {link}}}" for link in robot.feet]
    (program.folder / "humanoid.yaml").write_text("\n".join(lines) + "\n")
