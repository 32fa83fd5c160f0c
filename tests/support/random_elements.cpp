#include "support/random_elements.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>

#include "support/random_mechanism.h"

namespace mimbre::test {
namespace {

std::string word(const Vec3d& x) { return fmt::format("[{:.6g}, {:.6g}, {:.6g}]", x[0], x[1], x[2]); }

class Writer {
 public:
  explicit Writer(unsigned seed) : random_(seed), seed_(seed) {}

  RandomElements write() {
    signals();
    if (seed_ % 4 == 3)
      vehicle();
    else
      mechanism();
    const int count = 3 + random_.index(3);
    for (int k = 0; k < count; ++k) element((static_cast<int>(seed_) + 5 * k) % kinds);
    RandomElements made;
    made.text = fmt::format("gravity: {}\n", word(gravity_));
    for (const auto& [section, lines] : sections_) made.text += section + ":\n" + lines;
    made.text += "simulation: {step: 0.001}\n";
    for (int k = 0; k < 3; ++k)
      made.sets.push_back({random_elements_grid * (3 + 4 * k + random_.index(4)),
                           random_.chance(0.5) ? "u" : "w", number(-1, 1)});
    return made;
  }

 private:
  struct Joint {
    std::string name;
    int coordinate = 0;  ///< a scalar one; -1: it has none
    bool turns = true;
  };

  double number(double low, double high) { return random_.number(low, high); }
  Vec3d vector(double size) { return random_.vector(size); }
  void add(const std::string& section, const std::string& line) { sections_[section] += "  " + line + "\n"; }
  std::string name(const char* kind) { return fmt::format("{}{}", kind, ++names_); }

  /// Inputs, and signals that jump: u at events and by the host, s at instants, relay by a relay.
  void signals() {
    add("inputs", fmt::format("u: {:.3g}", number(-1, 1)));
    add("inputs", fmt::format("w: {{start: {:.3g}, hold: linear}}", number(-1, 1)));
    add("signals", fmt::format("s: {{value: \"sin({:.3g}*t) + 0.5*u\", every: {}}}", number(10, 30),
                               random_elements_grid));
    add("signals", fmt::format("relay: {{hysteresis: \"sin({:.3g}*t)\", rises_at: 0.3, falls_at: -0.2}}",
                               number(10, 30)));
    if (random_.chance(0.7))
      add("events", fmt::format("jump: {{when: t, crosses: {:.6g}, set: {{u: {:.3g}}}}}", number(0.05, 0.35),
                                number(-1, 1)));
  }

  /// A factor of about 1 that may jump.
  std::string factor() {
    switch (random_.index(8)) {
      case 0:
        return "u";
      case 1:
        return "w";
      case 2:
        return "s";
      case 3:
        return "(relay - 0.4)";
      case 4:
        return fmt::format("(t < {:.5g} ? 1 : -0.5)", number(0.1, 0.3));
      case 5:
        return fmt::format("sin({:.3g}*t)", number(3, 15));
      case 6:
        return "(u + s)";
      default:
        return fmt::format("{:.3g}", number(-1, 1));
    }
  }

  void body(const std::string& called, const Vec3d& at, double mass, double inertia) {
    const double i[] = {inertia * number(1, 1.4), inertia * number(1, 1.4), inertia * number(1, 1.4)};
    add("bodies", fmt::format("{}: {{mass: {:.3g}, com: {}, inertia: [{:.5g}, {:.5g}, {:.5g}]}}", called,
                              mass, word(at), i[0], i[1], i[2]));
    bodies_.push_back(called);
    places_.push_back(at);
  }

  void mechanism() {
    gravity_ = random_.chance(0.7) ? vector(6) : Vec3d(Vec3d::Zero());
    const int count = 2 + random_.index(3);
    for (int b = 0; b < count; ++b) {
      const Vec3d at = vector(0.6);
      const std::string called = fmt::format("b{}", b);
      const std::string parent = b == 0 || random_.chance(0.3) ? "ground" : bodies_[random_.index(b)];
      body(called, at, number(0.5, 2), number(0.03, 0.1));
      static const char* const types[] = {"revolute",  "prismatic", "cylindrical", "universal",
                                          "spherical", "planar",    "floating",    "revolute"};
      const std::string type = types[random_.index(8)];
      std::string text = fmt::format("j{}: {{type: {}, between: [{}, {}], at: {}", b, type, parent, called,
                                     word(at + vector(0.3)));
      const Vec3d axis = vector(1).normalized();
      if (type != "spherical" && type != "floating") text += ", axis: " + word(axis);
      if (type == "universal") text += ", axis2: " + word(axis.cross(vector(1)).normalized());
      const int rates = type == "revolute" || type == "prismatic"      ? 1
                        : type == "cylindrical" || type == "universal" ? 2
                        : type == "floating"                           ? 6
                                                                       : 3;
      std::string velocity;
      for (int k = 0; k < rates; ++k) velocity += fmt::format("{}{:.3g}", k ? ", " : "", number(-3, 3));
      text += fmt::format(", velocity: [{}]", velocity);
      if (rates == 1 && random_.chance(0.4))
        text +=
            fmt::format(", spring: {{stiffness: {:.3g}, damping: {:.2g}}}", number(5, 50), number(0, 0.5));
      add("joints", text + "}");
      if (type != "spherical" && type != "floating" && type != "planar") {
        const int coordinate = rates == 2 ? random_.index(2) : 0;
        joints_.push_back({fmt::format("j{}", b), coordinate,
                           type != "prismatic" && !(type == "cylindrical" && coordinate == 1)});
      }
    }
    if (random_.chance(0.15)) {  // a joint that moves as it is told
      const std::string called = fmt::format("b{}", count);
      body(called, vector(0.5), 0.7, 0.05);
      add("joints", fmt::format("driven: {{type: revolute, between: [{}, {}], at: {}, axis: {}, drive: "
                                "{{position: \"{:.3g}*sin({:.3g}*t)\"}}}}",
                                bodies_[0], called, word(vector(0.5)), word(vector(1).normalized()),
                                number(0.2, 0.8), number(3, 9)));
    }
  }

  /// A body on two wheels, one behind the other, that can go along, up and down, and nod.
  void vehicle() {
    gravity_ = {0, 0, -9.81};
    body("car", {0, 0, 0.6}, 300, 40);
    const double speed = number(1, 8);
    add("joints",
        fmt::format("plane: {{type: planar, between: [ground, car], at: [0, 0, 0.6], axis: [0, 1, 0], "
                    "velocity: [0, {:.4g}, {:.3g}]}}",
                    speed, number(-0.2, 0.2)));
    add("roads",
        random_.chance(0.4) ? std::string("road: {over: distance, points: [[-100, 0], [100, 0]]}")
        : random_.chance(0.5)
            ? fmt::format("road: {{over: grid, origin: [-20, -3], spacing: [0.7, 3], heights: {}}}", hills())
            : fmt::format("road: {{over: time, height: \"0.02*{}\"}}", factor()));
    const char* const law = random_.chance(0.7)
                                ? "model: brush, stiffness: 2e5, damping: 500, radius: 0.3, "
                                  "longitudinal_stiffness: 3e4, cornering_stiffness: 3e4, friction: 0.9, "
                                  "longitudinal_relaxation: 0.3, lateral_relaxation: 0.5, half_length: 0.07, "
                                  "load: 1600, rolling_resistance: 0.01"
                                : "stiffness: 2e5, radius: 0.3";
    for (const double side : {-1.0, 1.0}) {
      const std::string called = side < 0 ? "rear" : "front";
      const Vec3d at(side, 0, 0.292 + number(0, 0.02));
      body(called, at, 15, 0.6);
      add("joints",
          fmt::format("{0}: {{type: revolute, between: [car, {0}], at: {1}, axis: [0, 1, 0], velocity: "
                      "{2:.4g}}}",
                      called, word(at), speed / 0.295));
      add("tyres", fmt::format("{0}: {{on: {0}, at: {1}, road: road, {2}}}", called, word(at), law));
      joints_.push_back({called, 0, true});
    }
  }
  std::string hills() {
    std::string rows;
    for (int r = 0; r < 3; ++r) {
      std::string row;
      for (int k = 0; k < 60; ++k) row += fmt::format("{}{:.3g}", k ? ", " : "", 0.02 * number(-1, 1));
      rows += fmt::format("{}[{}]", r ? ", " : "", row);
    }
    return "[" + rows + "]";
  }

  static constexpr int kinds = 16;
  std::string any_body() { return bodies_[random_.index(static_cast<int>(bodies_.size()))]; }
  /// Two that differ; the first may be the ground.
  std::pair<std::string, std::string> two() {
    const std::string second = any_body();
    std::string first = second;
    while (first == second) first = random_.chance(0.4) || bodies_.size() == 1 ? "ground" : any_body();
    return {first, second};
  }
  std::string between() {
    const auto [a, b] = two();
    return fmt::format("between: [{}, {}], at: {}", a, b, word(vector(0.5)));
  }
  std::string line() {
    const auto [a, b] = two();
    const Vec3d from = vector(0.5);
    return fmt::format("between: [{}, {}], at: [{}, {}]", a, b, word(from),
                       word(from + number(0.5, 0.9) * vector(1).normalized()));
  }
  const Joint& any_joint() { return joints_[random_.index(static_cast<int>(joints_.size()))]; }
  std::string on(const Joint& j) { return fmt::format("joint: {}, coordinate: {}", j.name, j.coordinate); }

  void element(int kind) {
    const double size = seed_ % 4 == 3 ? 100 : 1;  // vehicles are heavy
    if (joints_.empty() && (kind == 3 || (kind >= 7 && kind <= 10))) kind = 0;
    switch (kind) {
      case 0:
        return add("springs",
                   fmt::format("{}: {{{}, elastic: {{stiffness: {:.3g}, zero: 0.5}}, damping: "
                               "{{coefficient: {:.3g}}}}}",
                               name("spring"), line(), size * number(20, 200), size * number(0, 3)));
      case 1:
        return add("springs", fmt::format("{}: {{{}, force: \"{:.3g}*(l - 0.5) + {:.3g}*v*l + {:.3g}*{}\"}}",
                                          name("law"), line(), size * number(20, 100), size * number(0, 2),
                                          size * 4, factor()));
      case 2:
        return add("loads",
                   fmt::format("{}: {{on: {}, at: {}, force: {}, moment: {}, scale: \"{}\", follower: {}}}",
                               name("load"), any_body(), word(vector(0.5)), word(size * vector(5)),
                               word(size * vector(0.5)), factor(), random_.chance(0.5)));
      case 3: {
        const Joint& j = any_joint();
        return add("actuators", fmt::format("{}: {{{}, {}: \"{:.3g}*{}\"}}", name("motor"), on(j),
                                            j.turns ? "torque" : "force", size * number(0.3, 2), factor()));
      }
      case 4:
        return add("actuators",
                   fmt::format("{}: {{{}, about: {}, torque: \"{:.3g}*{}\"}}", name("gyro"), between(),
                               word(vector(1).normalized()), size * number(0.2, 1), factor()));
      case 5:
        return add("actuators",
                   fmt::format("{}: {{{}, along: {}, force: \"{:.3g}*{}\"}}", name("jet"), between(),
                               word(vector(1).normalized()), size * number(1, 5), factor()));
      case 6: {
        const double k = size * number(50, 300);
        return add(
            "bushings",
            fmt::format("{}: {{{}, stiffness: [{:.3g}, {:.3g}, {:.3g}, {:.3g}, {:.3g}, {:.3g}], damping: [1, "
                        "2, 1, 0.1, 0.1, 0.1], laws: {{z: {{elastic: \"300*x^3\"}}, rx: {{damping: 0.05}}}}, "
                        "maxwell: [{{stiffness: [50, 20, 30, 3, 2, 1], relaxation: 0.05}}]}}",
                        name("bushing"), between(), k, 2 * k, k, 0.02 * k, 0.03 * k, 0.05 * k));
      }
      case 7: {
        const Joint& j = any_joint();
        return add("frictions",
                   fmt::format("{}: {{{}, {}: \"{:.3g}*(1.2 + 0.5*{})\", sticking: 0.01, stribeck: 0.3, "
                               "static_ratio: 1.3, viscous: 0.05, settling: 0.01}}",
                               name("friction"), on(j), j.turns ? "torque" : "force", size * number(0.3, 1),
                               factor()));
      }
      case 8:
        return add("stops",
                   fmt::format("{}: {{{}, lower: {:.3g}, upper: {:.3g}, stiffness: {:.4g}, restitution: "
                               "{:.2g}, exponent: {}}}",
                               name("stop"), on(any_joint()), -number(0.1, 0.4), number(0.1, 0.4),
                               size * number(200, 600), number(0.4, 1), random_.chance(0.5) ? 1 : 1.5));
      case 9:
        return add(
            "torsion_springs",
            fmt::format("{}: {{coordinates: [{{{}}}, {{{}, factor: -0.7}}], stiffness: "
                        "{:.3g}, damping: 0.3, rest: \"0.2*{}\"}}",
                        name("bar"), on(any_joint()), on(joints_.back()), size * number(5, 30), factor()));
      case 10: {
        const Joint& j = any_joint();
        return add(
            "motors",
            random_.chance(0.5)
                ? fmt::format("{}: {{{}, ratio: 3, inertia: 1e-3, constant: 0.2, resistance: 0.8, voltage: "
                              "\"5*{}\", drag: 1e-3, efficiency: 0.9}}",
                              name("dc"), on(j), factor())
                : fmt::format("{}: {{{}, ratio: 2, curve: {{table: [[0, 0.5], [30, 0.2]]}}, command: {}}}",
                              name("drive"), on(j), "\"0.8*" + factor() + "\""));
      }
      case 11: {
        const auto [a, b] = two();
        const bool winch = random_.chance(0.6);
        return add("cables",
                   fmt::format("{}: {{over: [{}, {}, ground], at: [{}, {}, {}], axial_stiffness: {:.4g}, "
                               "damping: {:.2g}{}}}",
                               name("cable"), a, b, word(vector(0.4)), word(Vec3d(1, 0, 0) + vector(0.2)),
                               word(Vec3d(0.3, 1, 0) + vector(0.2)), size * number(50, 200), size * 0.5,
                               winch ? fmt::format(", length: \"1.8 + 0.1*{}\"", factor()) : ", preload: 3"));
      }
      case 12:
        return add("drags",
                   fmt::format("{}: {{on: {}, at: {}, area: 1, coefficients: [0.4, 0.8, 1.2]{}}}",
                               name("drag"), any_body(), word(vector(0.4)),
                               random_.chance(0.5) ? fmt::format(", wind: [5, 0, \"3*{}\"]", factor()) : ""));
      case 13:
        return add("gas_springs",
                   fmt::format("{}: {{{}, pressure: {:.4g}, area: 1e-4, length: 0.7, gas_length: 0.6, "
                               "damping: 1}}",
                               name("gas"), line(), 101325 + size * number(1e4, 1e5)));
      case 14: {
        const std::string called = any_body();
        Vec3d at;
        for (std::size_t k = 0; k < bodies_.size(); ++k)
          if (bodies_[k] == called) at = places_[k];
        const std::string plane = name("plane");
        const Vec3d normal = vector(1).normalized();
        add("surfaces", fmt::format("{}: {{type: half_space, at: {}, z: {}}}", plane,
                                    word(at - number(0.13, 0.3) * normal), word(normal)));
        return add("contacts",
                   fmt::format("{}: {{spheres: {{on: {}, at: {}, radius: 0.1}}, surfaces: [{}], "
                               "stiffness: {:.4g}, depth: 0.01, restitution: {:.2g}, friction: 0.4, "
                               "exponent: 1.5, settling: 0.01{}}}",
                               name("contact"), called, word(at), plane, size * number(1000, 3000),
                               number(0.5, 1), random_.chance(0.4) ? ", rolling: 0.01, spinning: 0.01" : ""));
      }
      default: {
        add("parameters", fmt::format("k{}: {{value: {:.3g}, tunable: true}}", names_ + 1, number(20, 60)));
        const std::string k = fmt::format("k{}", names_ + 1);
        add("events", fmt::format("stiffer{}: {{when: t, crosses: {:.5g}, set: {{{}: {:.3g}}}}}", names_ + 1,
                                  number(0.1, 0.3), k, number(20, 60)));
        return add("springs", fmt::format("{}: {{{}, force: \"{}*(l - 0.5)\"}}", name("tuned"), line(), k));
      }
    }
  }

  Random random_;
  const unsigned seed_;
  Vec3d gravity_ = Vec3d::Zero();
  std::map<std::string, std::string> sections_;
  std::vector<std::string> bodies_;
  std::vector<Vec3d> places_;
  std::vector<Joint> joints_;
  int names_ = 0;
};

}  // namespace

RandomElements random_elements(unsigned seed) { return Writer(seed).write(); }

}  // namespace mimbre::test
