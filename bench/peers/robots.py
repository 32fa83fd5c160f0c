"""A robot arm from its URDF file, in free motion from a speed in every joint."""

import pathlib
import re
import time
import xml.etree.ElementTree as xml
from importlib.metadata import distribution, version

import numpy as np
from program import Program
from runge_kutta import evaluation_seconds, rk4
from runner import Case, Runner, end_only, optional

EXACT = ["--integrator", "dopri853", "--accuracy", "1e-12", "--step", "0.01"]
END, STEPS = 1.0, (0.05, 0.02, 0.01, 0.005, 0.0025)
FREE = "1e3"  # rad: as good as no stops


def case(program: Program) -> Case:
    urdf = bare(ur5())
    joints = [joint.get("name") for joint in xml.fromstring(urdf).iter("joint") if joint.get("type") == "revolute"]
    speeds = [0.5 * (-1) ** i for i in range(len(joints))]
    write_model(program, urdf, dict(zip(joints, speeds, strict=True)))
    times = np.array([END])
    exact = program.outputs("robot.yaml", joints, times, EXACT)

    def own(options: str, steps: tuple[float, ...]) -> Runner:
        return program.runner("robot.yaml", joints, times, options, steps)

    runners = [own("", STEPS), own("--integrator rk4", STEPS), own("--integrator dopri853", (0.2, 0.1, 0.05, 0.025))]
    runners += [own(f"--integrator dopri853 --accuracy {accuracy}", (0.1,)) for accuracy in ("1e-6", "1e-8", "1e-10")]
    peers = (in_exudyn, in_mujoco, in_pinocchio, in_drake)
    runners += optional([lambda peer=peer: peer(urdf, speeds) for peer in peers])
    return Case("robot arm UR5", f"joint angles after {END:g} s", "rad", exact, runners)


def ur5() -> pathlib.Path:
    """The file, in the package example-robot-data."""
    files = distribution("example-robot-data").files or []
    return pathlib.Path(next(file for file in files if file.name == "ur5_robot.urdf").locate())


def bare(path: pathlib.Path) -> str:
    """The robot without shapes, transmissions, friction, dampers and stops."""
    robot = xml.parse(path).getroot()
    for link in robot.iter("link"):
        for shape in [*link.findall("visual"), *link.findall("collision")]:
            link.remove(shape)
    for joint in robot.iter("joint"):
        for part in [*joint.findall("dynamics"), *joint.findall("safety_controller")]:
            joint.remove(part)
        limit = joint.find("limit")
        if limit is not None:
            limit.set("lower", f"-{FREE}")
            limit.set("upper", FREE)
    for part in [part for part in robot if part.tag not in ("link", "joint")]:
        robot.remove(part)
    return xml.tostring(robot, encoding="unicode")


def write_model(program: Program, urdf: str, speeds: dict[str, float]) -> None:
    """The converted model, without stops and with speeds."""
    (program.folder / "robot.urdf").write_text(urdf)
    program.call("convert", "robot.urdf", "-o", "robot.yaml")
    lines, section = [], ""
    for line in (program.folder / "robot.yaml").read_text().splitlines():
        if line and line[0] not in " #":
            section = line.split(":")[0]
        joint = re.match(r"^  (\S+): \{type: revolute, ", line)
        if joint and joint[1] in speeds:
            line = f"{line[: line.rindex('}')]}, velocity: {speeds[joint[1]]}}}"
        if section not in ("stops", "frictions"):
            lines.append(line)
    (program.folder / "robot.yaml").write_text("\n".join(lines) + "\n")


def in_exudyn(urdf: str, speeds: list[float]) -> list[Runner]:
    import exudyn_solver
    import robot_in_exudyn

    def runner(rule: str, said: str, **options: float) -> Runner:
        both = end_only(lambda step: robot_in_exudyn.run(urdf, speeds, rule, END, step, **options))
        return Runner("Exudyn", exudyn_solver.VERSION, f"kinematic tree, {said}", STEPS, **both, finest=min(STEPS) / 8)

    said = "generalised-alpha 0.9, modified Newton, tolerance 1e-05, dense"
    runners = [runner(rule, f"{rule}, dense") for rule in ("RK44", "RK67")]
    return [*runners, runner("generalised-alpha", said, rho=0.9, tolerance=1e-5)]


def in_mujoco(urdf: str, speeds: list[float]) -> list[Runner]:
    import mujoco
    from chain_in_mujoco import INTEGRATORS

    spec = mujoco.MjSpec.from_string(urdf)
    spec.option.disableflags = int(mujoco.mjtDisableBit.mjDSBL_CONTACT | mujoco.mjtDisableBit.mjDSBL_CONSTRAINT)
    model = spec.compile()

    def run(integrator: str, step: float) -> tuple[np.ndarray, float]:
        model.opt.timestep, model.opt.integrator = step, INTEGRATORS[integrator]
        data = mujoco.MjData(model)
        data.qvel[:] = speeds
        begin = time.process_time()
        mujoco.mj_step(model, data, round(END / step))
        return data.qpos.copy(), time.process_time() - begin

    def runner(integrator: str) -> Runner:
        both = end_only(lambda step: run(integrator, step))
        return Runner("MuJoCo", mujoco.__version__, integrator, STEPS, **both, finest=min(STEPS) / 8)

    return [runner(integrator) for integrator in INTEGRATORS]


def in_pinocchio(urdf: str, speeds: list[float]) -> list[Runner]:
    import pinocchio as pin

    model = pin.buildModelFromXML(urdf)
    data, zero, start = model.createData(), np.zeros(model.nv), np.array(speeds)

    def acceleration(q: np.ndarray, v: np.ndarray) -> np.ndarray:
        return pin.aba(model, data, q, v, zero)

    return [
        Runner(
            "Pinocchio",
            pin.__version__,
            "aba, RK4: time of the evaluations alone",
            STEPS,
            lambda step: rk4(acceleration, zero, start, step, round(END / step))[None],
            lambda step: evaluation_seconds(acceleration, zero, start, 4 * round(END / step)),
            min(STEPS) / 8,
        )
    ]


def in_drake(urdf: str, speeds: list[float]) -> list[Runner]:
    from pydrake.multibody.parsing import Parser
    from pydrake.multibody.plant import MultibodyPlant
    from pydrake.systems.analysis import ResetIntegratorFromFlags, Simulator

    plant = MultibodyPlant(time_step=0.0)
    Parser(plant).AddModelsFromString(urdf, "urdf")
    plant.mutable_gravity_field().set_gravity_vector([0, 0, -9.81])
    plant.Finalize()

    def run(scheme: str, step: float) -> tuple[np.ndarray, float]:
        simulator = Simulator(plant)
        context = simulator.get_mutable_context()
        plant.SetVelocities(context, np.array(speeds))
        ResetIntegratorFromFlags(simulator, scheme, step).set_fixed_step_mode(True)
        simulator.Initialize()
        begin = time.process_time()
        simulator.AdvanceTo(END)
        return plant.GetPositions(context).copy(), time.process_time() - begin

    def runner(scheme: str) -> Runner:
        both = end_only(lambda step: run(scheme, step))
        return Runner("Drake", version("drake"), f"continuous, {scheme}", STEPS, **both, finest=min(STEPS) / 8)

    return [runner("runge_kutta3"), runner("runge_kutta5")]
