#!/usr/bin/env python3
"""Runs an open chain of N links (bench/chain.py) in mimbre, MuJoCo and Pinocchio, and prints errors and CPU times.

bench/chain_peers.py N [PROGRAM]     needs the packages numpy, mujoco and pin

The error is that of the tip's height after 0.5 s, in m, against mimbre's dopri853 with an accuracy of 1e-11. MuJoCo
makes its steps in C; Pinocchio has no integrator: "aba" is the time of its four evaluations a step alone.
"""

import json
import pathlib
import subprocess
import sys
import tempfile
import time

import mujoco
import numpy as np
import pinocchio as pin

n, end = int(sys.argv[1]), 0.5
program = sys.argv[2] if len(sys.argv) > 2 else "build/release/mimbre"
start = np.array([round(0.1 * ((7 * i) % 5 - 2), 1) for i in range(n)])


def mimbre(folder: pathlib.Path, *options: str) -> tuple[float, float]:
    times = []
    for _ in range(3):
        command = [program, "run", "chain.yaml", "--json", "-q", "-o", "chain.h5", "--until", str(end), *options]
        summary = json.loads(subprocess.run(command, cwd=folder, capture_output=True, text=True, check=True).stdout)
        times.append(summary["cpu_seconds"])
    return summary["outputs"]["tip"], min(times)


def mujoco_chain() -> mujoco.MjModel:
    spec = mujoco.MjSpec()
    spec.option.gravity = [0, 0, -9.81]
    spec.option.integrator = mujoco.mjtIntegrator.mjINT_RK4
    spec.option.disableflags = int(mujoco.mjtDisableBit.mjDSBL_CONTACT)
    body = spec.worldbody
    for i in range(n):
        body = body.add_body(
            pos=[min(i, 1), 0, 0], mass=1, ipos=[0.5, 0, 0], inertia=[0.01, 0.09, 0.09], explicitinertial=True
        )
        body.add_joint(type=mujoco.mjtJoint.mjJNT_HINGE, axis=[0, 1, 0] if i % 2 == 0 else [0, 0, 1])
    body.add_site(name="tip", pos=[1, 0, 0])
    return spec.compile()


def in_mujoco(model: mujoco.MjModel, step: float) -> tuple[float, float]:
    model.opt.timestep = step
    data = mujoco.MjData(model)
    data.qvel[:] = start
    begin = time.process_time()
    mujoco.mj_step(model, data, round(end / step))
    seconds = time.process_time() - begin
    mujoco.mj_kinematics(model, data)
    return data.site_xpos[0][2], seconds


def pinocchio_chain() -> pin.Model:
    model, parent = pin.Model(), 0
    model.gravity.linear = np.array([0, 0, -9.81])
    for i in range(n):
        joint = pin.JointModelRY() if i % 2 == 0 else pin.JointModelRZ()
        place = pin.SE3(np.eye(3), np.array([min(i, 1.0), 0, 0]))
        parent = model.addJoint(parent, joint, place, f"joint_{i}")
        inertia = pin.Inertia(1, np.array([0.5, 0, 0]), np.diag([0.01, 0.09, 0.09]))
        model.appendBodyToJoint(parent, inertia, pin.SE3.Identity())
    return model


def aba_seconds(model: pin.Model) -> float:
    data, zero, times = model.createData(), np.zeros(n), 200
    begin = time.process_time()
    for _ in range(times):
        pin.aba(model, data, zero, start, zero)
    return (time.process_time() - begin) / times


with tempfile.TemporaryDirectory() as name:
    folder = pathlib.Path(name)
    program = str(pathlib.Path(program).resolve())
    chain = subprocess.run([pathlib.Path(__file__).parent / "chain.py", str(n)], capture_output=True, check=True)
    (folder / "chain.yaml").write_bytes(chain.stdout)
    exact, _ = mimbre(folder, "--integrator", "dopri853", "--accuracy", "1e-11", "--step", "0.05")

    def show(what: str, step: object, result: tuple[float, float]) -> None:
        print(f"{n:5} {what:18} {step!s:7} {abs(result[0] - exact):9.2e} m {1e3 * result[1]:9.3f} ms", flush=True)

    model, aba = mujoco_chain(), aba_seconds(pinocchio_chain())
    for step in (0.02, 0.01, 0.005):
        rk4 = mimbre(folder, "--integrator", "rk4", "--step", str(step))
        show("mimbre rk4", step, rk4)
        show("mujoco rk4", step, in_mujoco(model, step))
        show("pinocchio rk4, aba", step, (rk4[0], 4 * aba * end / step))
    for step in (0.1, 0.05, 0.025):
        show("mimbre dopri853", step, mimbre(folder, "--integrator", "dopri853", "--step", str(step)))
    for accuracy in ("1e-4", "1e-6", "1e-8"):
        run = mimbre(folder, "--integrator", "dopri853", "--step", "0.1", "--accuracy", accuracy)
        show("mimbre dopri853", accuracy, run)
