"""The Bombardier Iltis of examples/iltis/vehicle.yaml with its flexible suspension, built in code: the same vehicle, to
the same bits. See there for where its numbers are from."""

import mimbre

Point = list[float]


def flexible_bar(part: mimbre.Subsystem, name: str, inner: Point, outer: Point, normal: Point) -> None:
    """A link or rod, held at its inner end, with x along it; `normal` is at right angles to it and to x of the car."""
    part.add_body(
        name,
        frame={"at": inner, "x": [b - a for a, b in zip(inner, outer, strict=True)], "y": [1, 0, 0]},
        flexible={
            "material": "steel",
            "section": name,
            "nodes": {"inner": inner, "outer": outer},
            "bars": {"bar": {"from": "inner", "to": "outer", "elements": 10}},
            "clamped": ["inner"],
            "static_modes": [
                {"node": "outer", "along": [1, 0, 0], "name": "outer.x"},
                {"node": "outer", "along": normal, "name": "outer.normal"},
            ],
            "dynamic_modes": 4,
            "stiffness_damping": 0.01,
        },
    )


def corner(part: mimbre.Subsystem, radius: float = 0.364325) -> None:
    """Wheel and suspension, written for the front left; its origin lies amid the axle, at the chassis' height."""
    front, rear, middle = [0.108, 0.259, -0.268], [-0.108, 0.259, -0.268], [0, 0.259, -0.268]
    ball, shock, normal = [0, 0.572066, -0.340982], [0.075, 0.500065, -0.328989], [0, 0.072982, 0.313066]
    link_inner, link_outer = [0, 0.1585, 0.030], [0, 0.488, -0.039]
    rod_inner, rod_outer = [-0.14, 0.070, 0.030], [-0.14, 0.447998, -0.039009]
    wheel = [0, 0.615038, -0.213972]

    part.add_material("steel", young=2.1e11, poisson=0.3, density=7850)
    part.add_section("arm", type="round", diameter=0.0379)
    part.add_section("link", type="tube", diameter=0.03, inner_diameter=0.024)
    part.add_section("rod", type="round", diameter=0.02)

    part.add_body(
        "arm",
        frame={"at": middle, "x": [1, 0, 0], "y": [0, 0.313066, -0.072982]},  # y along the arm
        flexible={
            "material": "steel",
            "section": "arm",
            "nodes": {"front": front, "rear": rear, "ball": ball, "shock": {"at": shock, "on": ["front", 0.8]}},
            "bars": {eye: {"from": eye, "to": "ball", "elements": 10} for eye in ("front", "rear")},
            "clamped": ["front", "rear"],
            "static_modes": [  # normal to the arm's plane
                {"node": "ball", "along": normal, "name": "ball.normal"},
                {"node": "shock", "along": normal, "name": "shock.normal"},
            ],
            "dynamic_modes": 2,
            "stiffness_damping": 0.01,
        },
    )
    flexible_bar(part, "link", link_inner, link_outer, [0, 0.069, 0.3295])
    flexible_bar(part, "rod", rod_inner, rod_outer, [0, 0.069009, 0.377998])
    part.add_body(  # with the wheel, which does not spin
        "axle",
        mass=57.35,
        com=wheel,
        inertia=[1.2402, 1.908, 1.2402],
        shapes=[{"cylinder": [radius, 0.18], "at": [0, 0.66, -0.213972], "axis": [0, 1, 0]}],
        lines=[[ball, wheel, link_outer, rod_outer]],
    )

    part.add_joint("arm", type="revolute", between=["chassis", "arm"], at=middle, axis=[1, 0, 0], cut="never")
    part.add_joint("ball", type="spherical", between=["arm", "axle"], at=ball, cut="never")
    part.add_joint("link", type="revolute", between=["chassis", "link"], at=link_inner, axis=[1, 0, 0], cut="never")
    part.add_joint(  # the rod's spin about its own axis is left out
        "rod",
        type="universal",
        between=["chassis", "rod"],
        at=rod_inner,
        axis=[1, 0, 0],
        axis2=[0, 0.069009, 0.377998],
        cut="never",
    )
    part.add_joint("link_ball", type="spherical", between=["link", "axle"], at=link_outer, cut="always")
    part.add_joint("rod_ball", type="spherical", between=["rod", "axle"], at=rod_outer, cut="always")

    part.add_spring(
        "leaf",
        between=["axle", "chassis"],
        at=[link_outer, [0, 0.488, 0.137]],
        elastic={
            "pieces": [
                {"until": 0.106, "polynomial": [35906 * (0.106 - 0.252) - 1e7 * 0.106, 1e7]},  # bump stop
                {"polynomial": [-35906 * 0.252, 35906]},
            ]
        },
    )
    part.add_spring(
        "shock",
        between=["arm", "chassis"],
        at=[shock, [0.075, 0.297, 0.062]],
        elastic={"polynomial": [-4.0092e6, 2.8397e7, -6.7061e7, 5.2796e7]},
        damping={
            "pieces": [
                {"until": -0.2, "polynomial": [-416.42, 1844.3]},
                {"until": 0.21, "polynomial": [0, 9945.627, 33955.72, -59832.25, -395651]},
                {"polynomial": [1919.1638, 1634.727]},
            ]
        },
    )
    part.add_tyre("tyre", on="axle", road="track", stiffness=4.6e5, radius=radius)


def vehicle(stairs: float = 0.1) -> mimbre.ModelBuilder:
    m = mimbre.ModelBuilder("Bombardier Iltis", gravity=[0, 0, -9.81], initial="assembled")
    m.add_body(
        "chassis",
        mass=1260,
        com=[0, 0, 0.57],
        inertia=[130, 1620, 1670],
        shapes=[
            {"box": [3.4, 1.0, 0.35], "at": [-0.05, 0, 0.72]},
            {"box": [1.6, 1.0, 0.45], "at": [-0.75, 0, 1.1]},  # cabin
            {"box": [0.05, 1.0, 0.4], "at": [0.1, 0, 1.08]},  # windscreen
        ],
    )
    m.add_joint("free", type="floating", between=["ground", "chassis"], velocity=[5, 0, 0, 0, 0, 0])
    steps = [(22, 5), (22, 4), (25, 4), (25, 3), (28, 3), (28, 2), (31, 2), (31, 1), (34, 1), (34, 0), (45, 0)]
    points = [(0, 0), (5, 0), (15, 5), *steps]
    m.add_road("track", over="distance", points=[[x, height * stairs] for x, height in points])

    m.place("front_left", corner, at=[0.970, 0, 0.57])
    m.place("front_right", corner, at=[0.970, 0, 0.57], mirror="y")
    m.place("rear_left", corner, at=[-1.047, 0, 0.57], mirror="x", radius=0.363812)
    m.place("rear_right", corner, at=[-1.047, 0, 0.57], mirror="xy", radius=0.363812)

    m.add_output("chassis.z", position="chassis", component="z")
    m.add_output("chassis.roll", roll="chassis")
    m.add_output("chassis.pitch", pitch="chassis")
    m.add_output("chassis.yaw", yaw="chassis")
    for name, side in {"front_left": 1, "front_right": -1, "rear_left": 1, "rear_right": -1}.items():
        m.add_output(f"wheel.{name}.z", position=f"{name}.axle", component="z")
        m.add_output(f"arm.{name}.deflection", deflection=f"{name}.arm.ball", along=[0, side * 0.072982, 0.313066])
        m.add_output(f"tyre.{name}.force", tyre_force=f"{name}.tyre")
    m.set_simulation(step=0.01, end=8, output_interval=0.01)
    return m


if __name__ == "__main__":
    run = vehicle(stairs=0.2).compile().run()
    print(f"chassis at {run['chassis.z'][-1]:.3f} m after {run.time[-1]:g} s")
