"""A humanoid that falls onto its feet in mimbre, MuJoCo and Drake.

The contact laws differ: mimbre and Drake have Hunt and Crossley's law (in mimbre its damping follows from the speed of
each impact), MuJoCo has soft constraints. So the distance to mimbre's converged run does not fall to zero.
"""

import numpy as np
from humanoid_model import Humanoid, g1, write_model
from program import Program
from runner import Case, Runner, optional

TIMES = np.arange(1, 201) * 0.01
END, STEPS = float(TIMES[-1]), (0.01, 0.005, 0.002, 0.001)


def case(program: Program) -> Case:
    robot = g1()
    write_model(program, robot)
    model, columns = "humanoid.yaml", ["x", "y", "z"]
    reference = program.outputs(model, columns, TIMES, ["--step", "1e-4"])
    runners = [program.runner(model, columns, TIMES, "", STEPS)]
    runners += optional([lambda: in_mujoco(program, robot), lambda: in_drake(robot)])
    what = f"position of the pelvis, mean over {END:g} s, with the difference of the contact laws"
    return Case("humanoid G1 on its feet", what, "m", reference, runners)


def in_mujoco(program: Program, robot: Humanoid) -> list[Runner]:
    import humanoid_in_mujoco as mujoco

    depths = [f"depth.{link}" for link in robot.feet]
    deepest = program.outputs("humanoid.yaml", depths, TIMES, ["--step", "1e-3"])[-1].max()
    print(f"humanoid: depth of the contacts after {END:g} s: mimbre {1e3 * deepest:.2f} mm", end="")

    def runner(cone: str) -> Runner:
        model = mujoco.build(robot, cone)
        print(f", MuJoCo, {cone} cones {1e3 * mujoco.depth(model, 'Euler', END, 1e-3):.2f} mm", end="", flush=True)
        return Runner(
            "MuJoCo",
            mujoco.VERSION,
            f"Euler, implicit in the joints' dampers, {cone} cones, its own contact stiffness",
            STEPS[1:],
            lambda step: mujoco.positions(model, "Euler", TIMES, step),
            lambda step: mujoco.seconds(model, "Euler", END, step),
            min(STEPS) / 4,
        )

    runners = [runner(cone) for cone in mujoco.CONES]
    print(flush=True)
    return runners


def in_drake(robot: Humanoid) -> list[Runner]:
    import humanoid_in_drake as drake

    def runner(approximation: str) -> Runner:
        return Runner(
            "Drake",
            drake.VERSION,
            f"discrete, {approximation}, point contact, gains of motors for springs",
            STEPS,
            lambda step: drake.positions(robot, approximation, TIMES, step),
            lambda step: drake.seconds(robot, approximation, END, step),
            min(STEPS) / 4,
        )

    return [runner(approximation) for approximation in drake.APPROXIMATIONS]
