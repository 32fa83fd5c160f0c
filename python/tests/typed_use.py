"""Not run: what type checkers must accept and refuse in the use of the package."""

from __future__ import annotations

import mimbre
import numpy as np

m = mimbre.ModelBuilder("Typed", gravity=np.zeros(3))
m.add_body("bar", mass="600 g", com=[0.5, 0, 0], inertia=np.ones(3))
m.add_body("bar", mas=1)  # type: ignore[call-arg]
m.add_joint("hinge", type="revolute", between=["ground", "bar"], position=0.1, drive={"speed": "2*pi"})
m.add_joint("hinge", type="hinge", between=["ground", "bar"])  # type: ignore[arg-type]
m.add_joint("hinge", type="revolute")  # type: ignore[call-arg]
model: mimbre.Model = m.compile()
run: mimbre.Run = model.run(until=1, formulation="natural", inputs={"u": 1, "v": ([0, 1], [2, 3]), "w": np.sin})
model.run(formulation="unnatural")  # type: ignore[arg-type]
total: float = float(run["bar.x"].sum())
sim: mimbre.Simulation = model.simulation(step=0.01)
sim.step()
sim.input("u").value = 1.0
model.fmu("typed.fmu", version=2, step=0.01).unlink()
model.fmu("typed.fmu", kind="me").unlink()
model.fmu("typed.fmu", kind="both")  # type: ignore[arg-type]
model.fmu("typed.fmu", version=1)  # type: ignore[arg-type]
model.generate("code").unlink()
state: bytes = sim.clone().save()
body: mimbre.ReducedBody = mimbre.reduce(
    "arm.inp", interfaces={"a": "set:a", "b": mimbre.Interface([1, 2], tie="mean")}
)
m.add_body("arm", reduced=body, frame={"at": [0, 0, 0]})
m.add_law("strut", force=lambda t, x, v: 100 * x, between=["ground", "bar"])
m.add_law("strut", force=12.5, joint="hinge")  # type: ignore[arg-type]
at_rest: float = mimbre.static(model)["angle"]
turned: float = float(model.kinematics(steps=10).of("hinge")[-1])
model.inverse_dynamics(([0, 1], {"hinge": [0, 1]}), flexible="static")  # type: ignore[arg-type]
torque: float = float(model.inverse_dynamics("motion.csv")["hinge"].max())
agree: bool = model.verify(until=1).agree
worst: float = max(d.relative for d in mimbre.compare(run, "other.h5").values())
linear: mimbre.LinearModel = model.linearise(at="equilibrium", inputs={"u": 1})
gains: float = float(np.abs(linear.response([1, 2])).max()) + float(linear.A[0, 0])
model.linearise(at="noon")  # type: ignore[arg-type]
hertz: list[float] = [mode.frequency for mode in model.modes(most=3, at=0.5)]
names: list[str] = [branch.name for branch in model.campbell("rpm", [0, 100], speed="rpm").branches]
