"""The vehicle on stairs and its single suspension in Exudyn; all laws and roads are symbolic functions."""

import exudyn_solver as solver
import numpy as np
from corner_in_exudyn import Model, add_corner, either
from exudyn.itemInterface import ObjectJointGeneric

CORNERS = [  # x of the axle, sign of x offsets, sign of y, radius of the wheel
    (0.970, 1, 1, 0.364325),
    (0.970, 1, -1, 0.364325),
    (-1.047, -1, 1, 0.363812),
    (-1.047, -1, -1, 0.363812),
]
DROP, AT = 0.2, 2.0  # m, s: of the road under the single suspension


def on_stairs(stairs: float, flexible: bool) -> Model:
    def road(x, t):
        height = x * 0.0
        for end, level in ((34.0, 1), (31.0, 2), (28.0, 3), (25.0, 4), (22.0, 5)):
            height = either(x < end, x * 0.0 + level * stairs, height)
        return either(x < 5.0, x * 0.0, either(x < 15.0, (x - 5.0) * (stairs / 2), height))

    model = Model(1260.0, [130.0, 1620, 1670], 5.0, flexible)
    for corner in CORNERS:
        add_corner(model, *corner, road)
    return model


def single_suspension(flexible: bool) -> Model:
    """Its chassis moves only up and down."""

    def road(x, t):
        return either(t < AT, x * 0.0, x * 0.0 - DROP)

    model = Model(315.0, [32.5, 405, 417.5], 0.0, flexible)
    add_corner(model, *CORNERS[0], road)
    markers = [model.frame(model.ground_body, np.array([0.0, 0, 0.57]), np.eye(3))]
    markers.append(model.frame(model.chassis, np.zeros(3), np.eye(3)))
    model.mbs.AddObject(ObjectJointGeneric(markerNumbers=markers, constrainedAxes=[1, 1, 0, 1, 1, 1]))
    return model


def seconds(model: Model, end: float, step: float, **options: float) -> float:
    model.mbs.Assemble()
    return solver.implicit(model.mbs, solver.settings(end, step, **options))


def heights(model: Model, times: np.ndarray, step: float, **options: float) -> np.ndarray:
    """Of the chassis."""
    sensor = model.sensor()
    model.mbs.Assemble()
    chosen = solver.settings(float(times[-1]), step, **options)
    chosen.solution.sensors.active, chosen.solution.sensors.writePeriod = True, min(step, 0.01)
    solver.implicit(model.mbs, chosen)
    table = np.array(model.mbs.GetSensorStoredData(sensor))
    return np.interp(times, table[:, 0], table[:, 3])[:, None]
