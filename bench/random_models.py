"""Random models for the benches: the same seed gives the same model.

A tree of rigid and flexible bodies with every type of joint, loops closed by joints and constraints, every kind of
force element, tyres, contacts, inputs, signals, blocks and events; both formulations, all integrators and formalisms.
A few stop before their end: contacts in depth at the start, formalisms that let constraints drift.
"""

import math
import random

AXES = {"revolute", "prismatic", "cylindrical", "universal", "planar"}
SCALAR = {"revolute", "prismatic"}
LOOPS = ("distance", "on_line", "on_plane", "on_curve", "spherical", "cylindrical", "parallel")


class Draw:
    """A model under construction."""

    def __init__(self, seed):
        self.r = random.Random(seed)
        self.bodies, self.places, self.flexible = {}, {}, {}
        self.joints, self.constraints = {}, {}
        self.sections = {}

    def number(self, low, high):
        return self.r.uniform(low, high)

    def positive(self, low, high):
        return math.exp(self.r.uniform(math.log(low), math.log(high)))

    def chance(self, share):
        return self.r.random() < share

    def near(self, place, size=0.4):
        return [x + self.number(-size, size) for x in place]

    def direction(self):
        while True:
            v = [self.number(-1, 1) for _ in range(3)]
            length = math.sqrt(sum(x * x for x in v))
            if 0.1 < length < 1:
                return [x / length for x in v]

    def across(self, axis):
        """A direction at right angles to a unit vector."""
        v = self.direction()
        part = sum(a * b for a, b in zip(v, axis, strict=True))
        v = [x - part * a for x, a in zip(v, axis, strict=True)]
        length = math.sqrt(sum(x * x for x in v))
        return [x / length for x in v] if length > 0.1 else self.across(axis)

    def add(self, section, name, content):
        self.sections.setdefault(section, {})[f"{name}{len(self.sections.get(section, {}))}"] = content

    # Bodies and joints

    def rigid_body(self, place):
        mass = self.positive(0.3, 5)
        second = [mass * self.number(0.002, 0.03) for _ in range(3)]
        inertia = [second[1] + second[2], second[0] + second[2], second[0] + second[1]]
        body = {"mass": mass, "com": place, "inertia": inertia}
        if self.chance(0.5):
            x = self.direction()
            body["frame"] = {"at": self.near(place, 0.2), "x": x, "y": self.across(x)}
        return body

    def flexible_body(self, name, place):
        along = self.direction()
        tip = [p + self.number(0.4, 1.0) * a for p, a in zip(place, along, strict=True)]
        middle = [0.5 * (a + b) for a, b in zip(place, tip, strict=True)]
        middle = self.near(middle, 0.1)
        self.flexible[name] = {"root": place, "middle": middle, "tip": tip}
        return {
            "frame": {"at": place},
            "flexible": {
                "material": "light",
                "section": "bar",
                "nodes": self.flexible[name],
                "bars": {"a": {"from": "root", "to": "middle"}, "b": {"from": "middle", "to": "tip"}},
                "clamped": ["root"],
                "static_modes": [{"node": "tip", "along": self.direction()}, {"node": "middle", "about": [0, 0, 1]}],
                "dynamic_modes": self.r.randint(1, 3),
                "stiffness_damping": self.r.choice([0, 1e-3]),
                "stiffening": self.r.choice(["linear", "linear", "foreshortening", "geometric_stiffness"]),
            },
        }

    def point(self, body):
        """A point of a body: of a flexible one its root, where joints and forces may be without a static mode."""
        if body in self.flexible:
            return list(self.r.choice(list(self.flexible[body].values())))
        return self.near(self.places[body])

    def tree(self):
        for k in range(self.r.randint(1, 6)):
            name = f"b{k}"
            place = [self.number(-1, 1), self.number(-1, 1), self.number(0.5, 2)]
            carrier = self.r.choice(["ground", *self.bodies])
            flexible = self.chance(0.25)
            self.places[name] = place
            self.bodies[name] = self.flexible_body(name, place) if flexible else self.rigid_body(place)
            kinds = ["revolute"] * 4 + ["prismatic"] * 2
            kinds += ["cylindrical", "universal", "spherical", "planar", "floating", "fixed"]
            kind = self.r.choice(kinds)
            pair = [carrier, name]
            if not flexible and carrier not in self.flexible and self.chance(0.3):
                pair.reverse()
            joint = {"type": kind, "between": pair}
            if kind not in ("floating", "fixed"):
                joint["at"] = list(place) if flexible else self.near(place, 0.3)
            if carrier in self.flexible:
                joint["at"] = list(self.r.choice(list(self.flexible[carrier].values())))
                if flexible:
                    joint |= {"type": "spherical", "between": [carrier, name]}
                    joint["at"] = list(self.flexible[carrier]["tip"])
                    self.move_flexible(name, joint["at"])
                elif kind == "floating":
                    joint = {"type": "spherical", "between": pair, "at": joint["at"]}
            if joint["type"] in AXES:
                joint["axis"] = self.direction()
            if joint["type"] == "universal":
                joint["axis2"] = self.across(joint["axis"])
            if joint["type"] in SCALAR:
                if self.chance(0.3):
                    joint["spring"] = {"stiffness": self.positive(1, 100), "damping": self.positive(0.01, 1)}
                if self.chance(0.1):
                    joint["drive"] = {"position": f"{self.number(0.05, 0.3)}*(1-cos({self.number(1, 5)}*t))"}
                elif self.chance(0.6):
                    joint["velocity"] = self.number(-2, 2)
            self.joints[f"j{k}"] = joint

    def move_flexible(self, name, to):
        shift = [a - b for a, b in zip(to, self.places[name], strict=True)]
        nodes = self.flexible[name]
        for node in nodes:
            nodes[node] = [a + b for a, b in zip(nodes[node], shift, strict=True)]
        nodes["root"] = list(to)
        self.places[name] = list(to)
        self.bodies[name]["frame"] = {"at": list(to)}

    def loops(self):
        for k in range(self.r.choice([0, 0, 0, 1, 1, 2])):
            pair = self.r.sample(["ground", *self.bodies], 2)
            kind = self.r.choice(LOOPS)
            held = [body for body in pair if body != "ground"]
            place = self.point(self.r.choice(held))
            loop = {"type": kind, "between": pair}
            if kind in ("spherical", "cylindrical"):
                if any(body in self.flexible for body in pair):
                    continue
                loop |= {"at": place, "cut": "always"}
                if kind == "cylindrical":
                    loop["axis"] = self.direction()
                self.joints[f"loop{k}"] = loop
                continue
            if kind == "distance":
                loop["at"] = [self.end(body) for body in pair]
            elif kind == "parallel":
                loop["axis"] = self.direction()
            elif any(body in self.flexible for body in pair):
                continue
            else:
                loop["at"] = place
                if kind == "on_curve":
                    way = self.direction()
                    loop["points"] = [
                        [p + s * w + 0.1 * s * s * (i == 2) for i, (p, w) in enumerate(zip(place, way, strict=True))]
                        for s in (-1, -0.5, 0, 0.5, 1)
                    ]
                else:
                    loop["axis"] = self.direction()
            self.constraints[f"c{k}"] = loop
        scalar = [name for name, joint in self.joints.items() if joint["type"] in SCALAR and "drive" not in joint]
        if len(scalar) > 1 and self.chance(0.15):
            terms = [{"joint": name, "factor": self.number(0.3, 2)} for name in self.r.sample(scalar, 2)]
            self.constraints["coupling"] = {"type": "coupling", "terms": terms}
            for term in terms:
                self.joints[term["joint"]].pop("velocity", None)
        if self.constraints or any("cut" in joint for joint in self.joints.values()):
            # Velocities of several joints would contradict the loops.
            for joint in self.joints.values():
                joint.pop("velocity", None)

    # Forces

    def end(self, body):
        return self.near([0, 0, 1], 1.5) if body == "ground" else self.point(body)

    def ends(self):
        pair = self.r.sample(["ground", *self.bodies], 2)
        return {"between": pair, "at": [self.end(body) for body in pair]}

    def spring(self):
        law = {"elastic": {"stiffness": self.positive(10, 1000), "zero": self.number(0.1, 1)}}
        law["damping"] = {"coefficient": self.positive(0.1, 10)}
        if self.chance(0.3):
            law = {"force": f"{self.positive(10, 500)}*(l-0.5) + 2*v*abs(v) + 3*sin(20*t)"}
        self.add("springs", "spring", self.ends() | law)

    def cable(self):
        pair = self.ends()
        content = {"over": pair["between"], "at": pair["at"], "axial_stiffness": self.positive(1e3, 1e5)}
        self.add("cables", "cable", content | {"preload": self.number(0, 20), "damping": self.positive(1, 50)})

    def gas_spring(self):
        law = {"pressure": 3e6, "area": 2e-5, "length": 0.8, "gas_length": 0.5, "damping": 5}
        self.add("gas_springs", "gas", self.ends() | law)

    def bushing(self):
        body = self.r.choice(list(self.bodies))
        if body in self.flexible:
            return
        other = self.r.choice(["ground", *(b for b in self.bodies if b != body and b not in self.flexible)])
        stiffness = [self.positive(100, 1e4) for _ in range(3)] + [self.positive(1, 100) for _ in range(3)]
        content = {"between": [other, body], "at": self.near(self.places[body]), "stiffness": stiffness}
        content["damping"] = [1e-3 * k for k in stiffness]
        if self.chance(0.5):
            content["maxwell"] = [{"stiffness": stiffness, "relaxation": self.positive(0.005, 0.1)}]
        self.add("bushings", "bushing", content)

    def load(self):
        body = self.r.choice(list(self.bodies))
        load = {"on": body, "at": self.point(body), "force": [self.number(-5, 5) for _ in range(3)]}
        load["follower"] = self.chance(0.5)
        if self.chance(0.5):
            load["scale"] = f"sin({self.number(3, 30)}*t) + 0.3*exp(-t)"
        self.add("loads", "load", load)

    def drag(self):
        body = self.r.choice(list(self.bodies))
        wind = [self.number(-5, 5), self.number(-5, 5), f"0.5*sin({self.number(3, 30)}*t)"]
        content = {"on": body, "at": self.point(body), "area": self.positive(0.01, 0.5), "wind": wind}
        self.add("drags", "drag", content | {"coefficients": [self.number(0.2, 1.5) for _ in range(3)]})

    def contact(self):
        rigid = [body for body in self.bodies if body not in self.flexible]
        if not rigid:
            return
        surfaces = self.sections.setdefault("surfaces", {})
        low = self.number(-0.2, 0.4)
        wedge = {"vertices": [[-2, -2, low], [2, -2, low], [0, 2, low], [0, 0, low - 1]]}
        surfaces["floor"] = self.r.choice(
            [
                {"type": "half_space", "at": [0, 0, low]},
                {"type": "box", "on": "ground", "at": [0, 0, low], "size": [4, 4, 0.5]},
                {"type": "sphere", "at": [0, 0, low - 1], "radius": 1.2},
                {"type": "mesh"} | wedge | {"triangles": [[0, 1, 2], [0, 3, 1], [1, 3, 2], [2, 3, 0]]},
            ]
        )
        content = {
            "spheres": [{"on": body, "at": self.near(self.places[body], 0.2), "radius": 0.15} for body in rigid],
            "surfaces": ["floor"],
            "stiffness": self.positive(1e3, 1e5),
            "restitution": self.number(0.05, 0.9),
            "friction": self.number(0, 1),
        }
        if len(rigid) > 1 and self.chance(0.4):
            content["among"] = True
        self.add("contacts", "contact", content)

    def tyre(self):
        wheels = [
            (joint["between"][1], joint["axis"])
            for joint in self.joints.values()
            if joint["type"] == "revolute" and joint["between"][1] not in {"ground", *self.flexible}
        ]
        if not wheels:
            return
        wheel, axis = self.r.choice(wheels)
        self.sections["roads"] = {"road": {"over": "distance", "points": [[-5, 0], [0, 0], [5, self.number(-1, 1)]]}}
        content = {"on": wheel, "at": self.places[wheel], "road": "road", "stiffness": 1e4, "damping": 50}
        content["radius"] = self.places[wheel][2] + self.number(-0.1, 0.02)
        if self.chance(0.5):
            slip = {"longitudinal_stiffness": 3e3, "cornering_stiffness": 2e3, "friction": 0.9, "half_length": 0.05}
            slip |= {"longitudinal_relaxation": 0.1, "lateral_relaxation": 0.2, "load": 100}
            content |= {"model": "brush", "axis": axis} | slip
        else:
            del content["damping"]
        self.add("tyres", "tyre", content)

    def scalar_joint(self):
        free = [name for name, joint in self.joints.items() if joint["type"] in SCALAR and "drive" not in joint]
        return self.r.choice(free) if free else None

    def on_joint(self, kind):
        joint = self.scalar_joint()
        if joint is None:
            return
        turns = self.joints[joint]["type"] == "revolute"
        if kind == "frictions":
            limit = {"torque" if turns else "force": self.positive(0.05, 5)}
            content = {"static_ratio": 1.3, "stribeck": 0.01, "viscous": 0.1, "sticking": 1e-3}
            self.add(kind, "friction", {"joint": joint} | limit | content)
        elif kind == "stops":
            reach = self.number(0.02, 0.3)
            content = {"lower": -reach, "upper": reach, "stiffness": self.positive(100, 1e4)}
            self.add(kind, "stop", {"joint": joint} | content | {"restitution": self.number(0.1, 0.9)})
        elif kind == "torsion_springs":
            content = {"stiffness": self.positive(1, 100), "damping": 0.1}
            self.add(kind, "torsion", {"coordinates": [{"joint": joint, "factor": 1.5}]} | content)
        elif turns:
            content = {"ratio": 10, "inertia": 1e-4, "constant": 0.05, "resistance": 0.8, "current_limit": 15}
            self.add("motors", "motor", {"joint": joint, "voltage": "12*sin(3*t)"} | content)

    def controller(self):
        joint = self.scalar_joint()
        if joint is None:
            return
        signals = self.sections.setdefault("signals", {})
        if signals:
            return
        every = {"every": self.r.choice([0.005, 0.01])} if self.chance(0.5) else {}
        signals["wanted"] = {"value": f"0.3*sin({self.number(2, 10)}*t)"}
        signals["angle"] = {"joint": joint}
        limits = {"lower": -20, "upper": 20}
        gains = {"kp": self.positive(1, 50), "ki": self.positive(1, 20), "kd": 0.1, "filter": 0.01}
        signals["servo"] = {"pid": "angle", "setpoint": "wanted"} | gains | limits | every
        signals["smooth"] = {"transfer_function": "servo", "numerator": [100], "denominator": [1, 20, 100]}
        signals["late"] = {"delay": "angle", "time": 0.02}
        signals["jitter"] = {"noise": "normal", "deviation": 0.1, "seed": self.r.randint(1, 99), "every": 0.01}
        signals["slow"] = {"rate_limit": "wanted", "rising": 2, "falling": -1}
        force = "torque" if self.joints[joint]["type"] == "revolute" else "force"
        if force == "torque" or self.chance(0.7):
            self.add("actuators", "actuator", {"joint": joint, force: "0.1*smooth + jitter + 0.1*slow"})
        if self.chance(0.5):
            event = {"when": "angle", "crosses": self.number(-0.05, 0.05), "set": {"push": 1}}
            self.sections["inputs"] = {"push": {"start": 0, "unit": "1"}}
            self.sections["events"] = {"reached": event}
            body = self.r.choice(list(self.bodies))
            self.add("loads", "pushed", {"on": body, "at": self.point(body), "force": [0, 0, 3], "scale": "push"})

    def forces(self):
        kinds = [self.spring, self.spring, self.cable, self.gas_spring, self.bushing, self.load, self.drag]
        kinds += [self.contact, self.contact, self.controller, self.controller, self.tyre]
        on_joints = ["frictions", "stops", "torsion_springs", "motors"]
        kinds += [lambda kind=kind: self.on_joint(kind) for kind in on_joints]
        for _ in range(self.r.randint(1, 5)):
            self.r.choice(kinds)()

    def simulation(self, step, end):
        integrators = [{"type": "generalized_alpha", "rho": 0.4}] * 4
        integrators += [{"type": "newmark"}, {"type": "hht", "rho": 0.6}, {"type": "conserve"}]
        formulation = self.r.choice(["relative", "natural"])
        content = {"step": step, "end": end, "formulation": formulation, "integrator": self.r.choice(integrators)}
        if self.chance(0.2):
            content["formalism"] = self.r.choice(["index1", "baumgarte", "penalty", "index1_augmented", "independent"])
        elif self.chance(0.1):
            content["fixed_cost"] = True
        if self.flexible and self.chance(0.2):
            content["inertia"] = "projection"
        return content

    def outputs(self):
        outputs = [
            {"name": f"{body}.{axis}", "position": body, "component": axis} for body in self.bodies for axis in "xyz"
        ]
        outputs += [
            {"name": f"{body}.w{axis}", "angular_velocity": body, "component": axis}
            for body in self.bodies
            for axis in "xyz"
        ]
        scalar = [name for name, joint in self.joints.items() if joint["type"] in SCALAR]
        return outputs + [{"name": name, "joint": name} for name in scalar]


def random_model(seed, step=0.005, end=0.2):
    """The sections of a model file; JSON is YAML."""
    draw = Draw(seed)
    draw.tree()
    draw.loops()
    draw.forces()
    model = {"mimbre": 1, "gravity": [0, 0, draw.r.choice([0, -9.81, -9.81, -9.81])]}
    if draw.flexible:
        model["materials"] = {"light": {"young": 2e8, "poisson": 0.3, "density": 900}}
        model["sections"] = {"bar": {"type": "rectangle", "width": 0.05, "height": 0.03}}
    model |= {"bodies": draw.bodies, "joints": draw.joints}
    if draw.constraints:
        model["constraints"] = draw.constraints
    model |= draw.sections | {"outputs": draw.outputs()}
    return model | {"simulation": draw.simulation(step, end)}
