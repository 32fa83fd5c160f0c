#include "support/models.h"

namespace mimbre::test {

std::shared_ptr<const Model> model_of(const std::string& text) {
  return Model::compile(parse_model("mimbre: 1\ntitle: test\n" + text, "test.yaml", "."));
}

std::shared_ptr<const Model> example(const std::string& file, const std::map<std::string, std::string>& set) {
  return Model::compile(load_model(std::string(MIMBRE_SOURCE_DIR) + "/examples/" + file, set));
}

std::string four_bar_text(std::map<std::string, std::string> more, const std::string& pin) {
  return R"(
bodies:
  crank: {mass: 0.5, com: [0, 0, 0.1], inertia: [0.002, 0.002, 0.0001]}
  coupler: {mass: 0.8, com: [0.3, 0, 0.35], inertia: [0.01, 0.05, 0.04]}
  rocker: {mass: 1, com: [0.6, 0, 0.25], inertia: [0.02, 0.02, 0.0005]}
joints:
  crank: {type: revolute, between: [ground, crank], at: [0, 0, 0], axis: [0, 1, 0])" +
         more["crank"] + R"(}
  crank_pin: {type: revolute, between: [crank, coupler], at: [0, 0, 0.2], axis: [0, 1, 0])" +
         more["crank_pin"] + R"(}
  rocker: {type: revolute, between: [ground, rocker], at: [0.6, 0, 0], axis: [0, 1, 0])" +
         more["rocker"] + R"(}
  rocker_pin: {type: )" +
         pin + ", between: [coupler, rocker], at: [0.6, 0, 0.5]" + more["rocker_pin"] + "}\n";
}

std::shared_ptr<const Model> controlled_four_bar() {
  std::string text = four_bar_text({{"rocker", ", cut: always, spring: {stiffness: 4, damping: 0.2}"}});
  text.insert(text.find("joints:"), "  fan: {mass: 0.1, com: [0.6, 0, 0.3], inertia: [1e-4, 1e-4, 1e-4]}\n");
  return model_of(text + R"yaml(
  fan: {type: revolute, between: [rocker, fan], at: [0.6, 0, 0.3], axis: [0, 1, 0], drive: {speed: 3*wind}}
parameters: {k: {value: 30, tunable: true, min: 0}}
inputs:
  wanted: {start: 0.2, range: [-1, 1]}
  wind: {start: 1, hold: linear}
  turned: 0
signals:
  error: wanted - angle
  servo: {pid: angle, setpoint: wanted + 0.1*turned, kp: 5, ki: 8, kd: 0.2, filter: 0.02, upper: 3, lower: -3}
  late: {delay: rock, time: 0.023}
  lag: {transfer_function: late - 0.5*lag + gusts, numerator: [1, 3], denominator: [0.01, 0.3, 2]}
  slow: {rate_limit: 3*angle, rising: 2}
  relay: {hysteresis: rock, rises_at: 0.02, falls_at: -0.02}
  sampled: {state_space: [jerk, angle], A: 0.9, B: [[0.001, 0.1]], C: 1, every: 0.012}
  gusts: {noise: normal, deviation: 0.1, seed: 3, every: 0.01}
  lift: {value: 2*height + 0.01*jerk, every: 0.015}
  angle: {joint: crank}
  rate: {joint_velocity: crank}
  rock: {joint: rocker}
  height: {position: coupler, component: z}
  jerk: {value: shaking, every: 0.02}
events:
  turns: {when: rate, set: {turned: angle - turned}}
  shaken: {when: shaking, crosses: 0.3, direction: rising}
actuators:
  motor: {joint: crank, torque: 20*error - 2*rate}
  brake: {joint: rocker, torque: -0.5*rock + 0.1*lag + 0.05*relay}
  second: {joint: crank, torque: servo + 0.1*slow + 0.1*sampled}
  piston: {between: [ground, coupler], at: [[0.3, 0, 0.9], [0.3, 0, 0.35]], force: lift + wind}
  twist: {between: [ground, rocker], at: [1, 0, 0], about: [0, 1, 0], torque: 0.1*sin(9*t)}
bushings:
  mount:
    between: [crank, coupler]
    at: [0.1, 0, 0.3]
    stiffness: [40, 40, 60, 1, 1, 1]
    damping: [1, 1, 1, 0.1, 0.1, 0.1]
    maxwell: [{stiffness: [50, 30, 20, 1, 1, 1], relaxation: 0.03}]
springs:
  tuned: {between: [ground, rocker], at: [[1, 0, 0.4], [0.6, 0, 0.3]], elastic: k*(l - 0.3), damping: 0.1*v*wind}
outputs:
  - {name: shaking, acceleration: coupler, component: x}
)yaml");
}

std::shared_ptr<const Model> geared_four_bar() {
  return model_of(four_bar_text({{"rocker", ", cut: always, spring: {stiffness: 4, damping: 0.2}"}}) + R"yaml(
inputs:
  throttle: {start: 0.3, range: [-1, 1]}
  wind: {start: 4, hold: linear}
signals: {rate: {joint_velocity: crank}}
torsion_springs:
  bar: {coordinates: [{joint: crank}, {joint: rocker, factor: -0.7}, {joint: crank_pin, factor: 0.2}], elastic: "3*x + 5*x^3", damping: 0.05}
cables:
  hoist: {over: [ground, coupler, ground, rocker], at: [[0.2, 0.1, 1], [0.3, 0, 0.35], [0.5, 0, 1], [0.6, 0, 0.3]], axial_stiffness: 60, damping: 0.4, length: "1.9 + 0.3*sin(8*t)"}
motors:
  dc: {joint: crank, constant: 0.02, resistance: 2, ratio: 5, inertia: 1e-4, voltage: "6*throttle - 0.1*rate", current_limit: 1.5}
  curve: {joint: rocker, curve: {table: [[0, 0.05], [40, 0.02], [90, 0]]}, command: throttle, ratio: -8, inertia: 5e-5, drag: 1e-4, efficiency: 0.9}
drags:
  sail: {on: coupler, at: [0.3, 0, 0.35], x: [0.6, 0, 0.8], z: [-0.8, 0, 0.6], area: 0.1, coefficients: [0.2, 0.5, 1.2], wind: [wind, 1, "0.2*wind"]}
)yaml");
}

std::shared_ptr<const Model> every_constraint() {
  return model_of(R"yaml(
bodies:
  plate: {mass: 5, com: [0, 0, -0.4], inertia: [0.3, 0.4, 0.2]}
  motor: {mass: 1, com: [-0.3, 1, 0], inertia: [0.01, 0.02, 0.02]}
  shaft: {mass: 1, com: [0.3, 1, -0.1], inertia: [0.01, 0.03, 0.03]}
  wheel: {mass: 2, com: [-0.3, 1.3, 0], inertia: [0.05, 0.1, 0.1]}
  rack: {mass: 1, com: [-0.3, 1, 0.1], inertia: [0.01, 0.01, 0.01]}
  pin: {mass: 0.8, com: [0.4, 0.05, -0.5], inertia: [0.02, 0.03, 0.025]}
  bead: {mass: 0.5, com: [0.1, 0.02, -1.2], inertia: [0.004, 0.003, 0.005]}
  foot: {mass: 1.5, com: [2, 0.1, 0.3], inertia: [0.03, 0.05, 0.04]}
  nut: {mass: 0.7, com: [-0.4, 0.02, -0.5], inertia: [0.006, 0.004, 0.005]}
joints:
  hinge: {type: revolute, between: [ground, plate], at: [0, 0, 0], axis: [0, 1, 0], velocity: 1}
  motor: {type: revolute, between: [ground, motor], at: [-0.3, 1, 0], axis: [1, 0, 0], velocity: 4}
  wheel: {type: revolute, between: [ground, wheel], at: [-0.3, 1.3, 0], axis: [1, 0, 0], cut: always}
  rack: {type: prismatic, between: [ground, rack], at: [-0.3, 1, 0.1], axis: [0, 1, 0]}
  foot: {type: floating, between: [ground, foot], velocity: [0.3, 0, 0, 0, 0.4, 2]}
constraints:
  gear: {type: gear, joints: [motor, wheel], teeth: [17, 51]}
  pinion: {type: rack, joints: [motor, rack], radius: 0.1}
  half_shaft: {type: constant_velocity, between: [motor, shaft], at: [0, 1, 0], axis: [1, 0, 0], axis2: [0.9, 0, -0.3]}
  slot: {type: on_line, between: [plate, pin], at: [0.4, 0, -0.5], axis: [0, 0.3, 1]}
  cross: {type: perpendicular, between: [plate, pin], axis: [1, 0, 0], axis2: [0, 1, 0]}
  rod: {type: distance, between: [ground, pin], at: [[1, 0.2, 0], [0.45, 0.1, -0.45]]}
  wire:
    type: on_curve
    between: [plate, bead]
    at: [0.1, 0, -1.2]
    points: [[-0.9, 0, -0.6], [-0.5, 0.1, -1], [0.1, 0, -1.2], [0.6, -0.1, -0.9], [0.8, 0.2, -0.4], [0, 0.3, -0.1]]
    closed: true
  table: {type: on_plane, between: [ground, foot], at: [2, 0, 0], axis: [0, 0.2, 1]}
  upright: {type: parallel, between: [ground, foot], axis: [0, 0.2, 1]}
  thread: {type: screw, between: [plate, nut], at: [-0.4, 0, -0.5], axis: [0.3, 0, 1], lead: 0.3}
)yaml");
}

std::shared_ptr<const Model> die_and_ball() {
  return model_of(R"yaml(
bodies:
  tray: {mass: 5, com: [0, 0, 0], inertia: [0.5, 0.5, 0.5]}
  die: {mass: 1, com: [0, 0, 0.16], inertia: [0.01, 0.008, 0.012]}
  ball: {mass: 0.5, com: [0.18, 0, 0.13], inertia: [0.002, 0.002, 0.002]}
joints:
  guide: {type: prismatic, between: [ground, tray], at: [0, 0, 0], axis: [0, 0, 1], spring: {stiffness: 2000, zero: 0.03, damping: 5}}
  die: {type: floating, between: [ground, die], velocity: [0.3, 0.1, 0, 1, 2, 3]}
  ball: {type: floating, between: [ground, ball], velocity: [-0.5, 0.3, 0, 4, 2, 3]}
surfaces:
  top: {type: box, on: tray, size: [1, 1, 0.1]}
  pole: {type: cylinder, at: [0.31, 0, 0], radius: 0.05, length: 1}
  bumps: {type: heights, at: [-0.5, -0.5, 0.03], spacing: [0.25, 0.5], heights: [[0, 0.01, 0.02, 0.01, 0], [0.01, 0.01, 0.01, 0.02, 0.01], [0, 0, 0.01, 0, 0]]}
contacts:
  corners:
    spheres: {on: die, at: [[-0.1, -0.1, 0.06], [0.1, -0.1, 0.06], [-0.1, 0.1, 0.06], [0.1, 0.1, 0.06]], radius: 0.03}
    surfaces: top
    stiffness: 2e3
    restitution: 0.6
    friction: 0.4
    static_ratio: 1.5
    settling: 1e-3
  round:
    spheres: [{on: ball, radius: 0.1}, {on: die, radius: 0.1}]
    surfaces: [top, pole, bumps]
    among: true
    stiffness: 2e3
    exponent: 1.5
    depth: 0.02
    restitution: 0.8
    friction: 0.3
    settling: 1e-3
    rolling: 0.002
    spinning: 0.001
outputs: [{name: height, position: die, component: z}]
simulation: {step: 0.002, end: 1}
)yaml");
}

}  // namespace mimbre::test
