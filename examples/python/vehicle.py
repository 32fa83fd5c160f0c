"""The Bombardier Iltis over stairs, from its model file."""

import mimbre

run = mimbre.Model.from_file("examples/iltis/vehicle.yaml", stairs=0.2).run()
print(f"chassis at {run['chassis.z'][-1]:.3f} m after {run.time[-1]:g} s")
print(f"{run.summary['real_time_factor']:.0f} times real time")
run.report("vehicle.html")
