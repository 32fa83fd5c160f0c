#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <Eigen/Geometry>
#include <filesystem>
#include <fstream>
#include <random>

#include "mimbre/model_file.h"
#include "mimbre/simulation.h"

/// Templates within templates, repeated things and files that include others.
namespace mimbre::templates_test {
namespace {

namespace fs = std::filesystem;
using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

spec::Model read(const std::string& text) { return parse_model(text, "model.yaml", ""); }

/// All mistakes, one in each line.
std::vector<std::string> mistakes(const std::string& text, const std::string& folder = "") {
  std::vector<std::string> lines;
  try {
    parse_model(text, "model.yaml", folder);
  } catch (const InputError& error) {
    for (const Diagnostic& d : error.diagnostics()) lines.push_back(to_string(d));
  }
  return lines;
}
std::string mistake(const std::string& text, const std::string& folder = "") {
  const auto all = mistakes(text, folder);
  return all.size() == 1 ? all.front() : fmt::format("{} mistakes\n{}", all.size(), fmt::join(all, "\n"));
}

std::vector<double> channels_after(const spec::Model& model, int steps) {
  Simulation simulation(Model::compile(model));
  for (int k = 0; k < steps; ++k) simulation.step();
  ResultsRow row;
  simulation.sample(row);
  return {row.channels.begin(), row.channels.end()};
}

/// The same things in the same order, to the last bit; names may differ.
void expect_equal(const spec::Model& a, const spec::Model& b, double tolerance = 0) {
  ASSERT_EQ(a.bodies.size(), b.bodies.size());
  ASSERT_EQ(a.frames.size(), b.frames.size());
  ASSERT_EQ(a.joints.size(), b.joints.size());
  ASSERT_EQ(a.springs.size(), b.springs.size());
  ASSERT_EQ(a.loads.size(), b.loads.size());
  const auto same = [&](const auto& x, const auto& y) { return (x - y).cwiseAbs().maxCoeff() <= tolerance; };
  const auto same_pose = [&](const spec::Pose& x, const spec::Pose& y) {
    return same(x.position, y.position) && same(x.rotation, y.rotation);
  };
  for (std::size_t k = 0; k < a.bodies.size(); ++k) {
    EXPECT_TRUE(same_pose(a.bodies[k].pose, b.bodies[k].pose)) << a.bodies[k].name;
    EXPECT_EQ(a.bodies[k].mass, b.bodies[k].mass);
    EXPECT_TRUE(same(a.bodies[k].com, b.bodies[k].com)) << a.bodies[k].name;
    EXPECT_TRUE(same(a.bodies[k].inertia, b.bodies[k].inertia)) << a.bodies[k].name;
  }
  for (std::size_t k = 0; k < a.frames.size(); ++k) {
    EXPECT_TRUE(same_pose(a.frames[k].pose, b.frames[k].pose)) << a.frames[k].name;
    EXPECT_EQ(a.frames[k].body, b.frames[k].body) << a.frames[k].name;
  }
  for (std::size_t k = 0; k < a.joints.size(); ++k) {
    EXPECT_EQ(a.joints[k].frame_a, b.joints[k].frame_a) << a.joints[k].name;
    EXPECT_EQ(a.joints[k].frame_b, b.joints[k].frame_b) << a.joints[k].name;
    EXPECT_EQ(a.joints[k].initial_velocity, b.joints[k].initial_velocity);
  }
  for (std::size_t k = 0; k < a.loads.size(); ++k) {
    EXPECT_TRUE(same(a.loads[k].force, b.loads[k].force)) << a.loads[k].name;
    EXPECT_TRUE(same(a.loads[k].moment, b.loads[k].moment)) << a.loads[k].name;
  }
}

constexpr const char* chain_by_loops = R"yaml(mimbre: 1
parameters: {n: {value: 100, integer: true}, p: 0.05}
bodies:
  link$i:
    for: {i: {from: 1, to: n}}
    mass: 0.2
    com: [($i - 0.5)*p, 0, 0]
    inertia: [1e-5, 4e-5, 4e-5]
joints:
  hinge1: {type: revolute, between: [ground, link1], at: [0, 0, 0], axis: [0, 1, 0], velocity: 1}
  hinge$i:
    for: {i: {from: 2, to: n}}
    type: revolute
    between: [link$(i - 1), link$i]
    at: [($i - 1)*p, 0, 0]
    axis: [0, 1, 0]
outputs:
  - {name: end.z, position: link$(n), component: z}
  - {name: "hinge$k.angle", joint: hinge$k, for: {k: [1, 50, 100]}}
simulation: {step: 0.002, end: 0.1}
)yaml";

TEST(Repeats, AChainOfAHundredLinksIsTheOneWrittenOut) {
  std::string bodies, joints;
  for (int i = 1; i <= 100; ++i) {
    bodies += fmt::format(
        "  link{0}: {{mass: 0.2, com: [({0} - 0.5)*0.05, 0, 0], inertia: [1e-5, 4e-5, 4e-5]}}\n", i);
    joints += fmt::format(
        "  hinge{0}: {{type: revolute, between: [{1}, link{0}], at: [({0} - 1)*0.05, 0, 0], axis: [0, 1, "
        "0]{2}}}\n",
        i, i == 1 ? "ground" : fmt::format("link{}", i - 1), i == 1 ? ", velocity: 1" : "");
  }
  const std::string written = "mimbre: 1\nbodies:\n" + bodies + "joints:\n" + joints + R"yaml(outputs:
  - {name: end.z, position: link100, component: z}
  - {name: hinge1.angle, joint: hinge1}
  - {name: hinge50.angle, joint: hinge50}
  - {name: hinge100.angle, joint: hinge100}
simulation: {step: 0.002, end: 0.1}
)yaml";
  const spec::Model a = read(chain_by_loops), b = read(written);
  expect_equal(a, b);
  for (std::size_t k = 0; k < a.bodies.size(); ++k) EXPECT_EQ(a.bodies[k].name, b.bodies[k].name);
  ASSERT_EQ(a.outputs.size(), 4u);
  for (std::size_t k = 0; k < 4; ++k) EXPECT_EQ(a.outputs[k].name, b.outputs[k].name);
  EXPECT_EQ(channels_after(a, 10), channels_after(b, 10));
}

TEST(Repeats, SeveralIndicesWordsAndParameters) {
  const spec::Model model = read(R"yaml(mimbre: 1
parameters: {rows: 2}
bodies:
  "$side-$row.$(2*row + k)":
    for: {side: [left, right], row: {from: rows, to: 1, by: -1}, k: [0, 5]}
    mass: 1
    com: [$row*10 + $k, "$(side == right ? -1 : 1)*0.5", 0]
    inertia: [1, 1, 1]
)yaml");
  std::vector<std::string> names;
  for (const spec::Body& body : model.bodies) names.push_back(body.name);
  EXPECT_THAT(names, testing::ElementsAre("left-2.4", "left-2.9", "left-1.2", "left-1.7", "right-2.4",
                                          "right-2.9", "right-1.2", "right-1.7"));
  EXPECT_EQ(model.bodies[1].pose.position, Eigen::Vector3d(25, 0.5, 0));
  EXPECT_EQ(model.bodies[7].pose.position, Eigen::Vector3d(15, -0.5, 0));
}

TEST(Repeats, NegativeIndicesStandInBrackets) {
  const spec::Model model = read(R"yaml(mimbre: 1
bodies:
  b$(k + 2):
    for: {k: {from: -1, to: 1}}
    mass: 1
    com: [$k^2, 1-$k, $k]
    inertia: [1, 1, 1]
)yaml");
  ASSERT_EQ(model.bodies.size(), 3u);
  EXPECT_EQ(model.bodies[0].pose.position, Eigen::Vector3d(1, 2, -1));
  EXPECT_EQ(model.bodies[2].pose.position, Eigen::Vector3d(1, 0, 1));
}

TEST(Repeats, ThatRunOverNothingAreNothing) {
  const spec::Model model = read(R"yaml(mimbre: 1
bodies:
  one: {mass: 1, com: [0, 0, 0], inertia: [1, 1, 1]}
  b$k: {for: {k: {from: 1, to: 0}}, mass: 1, com: [0, 0, 0], inertia: [1, 1, 1]}
  c$k: {for: {k: []}, mass: 1, com: [0, 0, 0], inertia: [1, 1, 1]}
)yaml");
  EXPECT_EQ(model.bodies.size(), 1u);
}

TEST(Repeats, MistakesAreSaidOnceAndWhere) {
  const std::string body = ", com: [0, 0, 0], inertia: [1, 1, 1]}\n";
  EXPECT_EQ(
      mistake("mimbre: 1\nbodies:\n  b$i: {for: {i: {from: 1, to: 40}}, mass: -3" + body).substr(0, 100),
      "model.yaml:3:44: body 'b1': mass: -3 is negative; it must be 0 or more (likewise in b2, b3, b4, b5, ");
  EXPECT_THAT(mistake("mimbre: 1\nbodies:\n  b: {for: {i: [1, 2]}, mass: 1" + body),
              AllOf(HasSubstr("model.yaml:3:3"), HasSubstr("repeated under one name"), HasSubstr("b$i")));
  EXPECT_THAT(mistake("mimbre: 1\nbodies:\n  b$i: {for: {i: {from: 1}}, mass: 1" + body),
              HasSubstr("'to' is missing"));
  EXPECT_THAT(mistake("mimbre: 1\nbodies:\n  b$i: {for: {i: {from: 1, to: 2, by: 0}}, mass: 1" + body),
              HasSubstr("never come to its end"));
  EXPECT_THAT(mistake("mimbre: 1\nbodies:\n  b$i: {for: {i: {from: 1, to: 2.5}}, mass: 1" + body),
              HasSubstr("not a whole number"));
  EXPECT_THAT(mistake("mimbre: 1\nbodies:\n  b$i: {for: {i: {from: 1, to: 1e8}}, mass: 1" + body),
              HasSubstr("more than 500000 values"));
  EXPECT_THAT(mistake("mimbre: 1\nbodies:\n  a$i: {for: {i: {from: 1, to: 4e5}}, mass: 1" + body +
                      "  b$i: {for: {i: {from: 1, to: 4e5}}, mass: 1" + body),
              HasSubstr("more than 500000 values when all"));
  EXPECT_THAT(mistakes("mimbre: 1\nbodies:\n  b$i: {for: 3, mass: 1" + body).back(),
              HasSubstr("indices with what they run over"));
  EXPECT_THAT(mistake("mimbre: 1\nbodies:\n  a: {mass: $(2*m)" + body),
              AllOf(HasSubstr("model.yaml:3:"), HasSubstr("'m' is not a parameter")));
  EXPECT_THAT(mistake("mimbre: 1\nbodies:\n  a: {mass: $(2" + body), HasSubstr("not closed"));
}

/// A template that stands in mirrored, turned templates is where it would stand if it were written once for
/// all.
TEST(NestedTemplates, AreTheFlatModel) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> uniform(-2, 2);
  const char* const mirrors[] = {"none", "x", "y", "z", "xy", "yz", "xyz"};
  for (int trial = 0; trial < 30; ++trial) {
    const auto triple = [&] { return Eigen::Vector3d(uniform(random), uniform(random), uniform(random)); };
    const auto text = [](const Eigen::Vector3d& v) {
      return fmt::format("[{:.17g}, {:.17g}, {:.17g}]", v[0], v[1], v[2]);
    };
    struct Place {
      Eigen::Vector3d at, rotate;
      std::string mirror;
    };
    const auto any = [&] { return Place{triple(), triple(), mirrors[random() % std::size(mirrors)]}; };
    const Place inner = any(), outer = any();
    const auto keys = [&](const Place& p) {
      return fmt::format("at: {}, rotate: {}, mirror: {}", text(p.at), text(p.rotate), p.mirror);
    };
    const std::string content = fmt::format(R"yaml(
    bodies:
      arm: {{mass: 2, com: {0}, inertia: [1, 2, 2.5, 0.1, 0.2, 0.3], frame: {{at: {1}, x: [1, 2, 0]}}}}
      tip: {{mass: 1, com: {2}, inertia: [1, 1, 1]}}
    frames:
      hook: {{body: arm, at: {3}, z: [1, 1, 1]}}
    joints:
      pin: {{type: revolute, between: [base, arm], at: {1}, axis: [0, 1, 2], velocity: 0.3}}
      slide: {{type: prismatic, between: [arm, tip], at: {2}, axis: [1, 1, 0], velocity: 0.2}}
    loads:
      push: {{on: hook, force: [1, 2, 3], moment: [3, 2, 1]}}
)yaml",
                                            text(triple()), text(triple()), text(triple()), text(triple()));
    const std::string nested =
        "mimbre: 1\nbodies:\n  base: {mass: 3, com: [0, 0, 0], inertia: [1, 1, 1]}\nsubsystems:\n  limb:" +
        content + "  pair:\n    instances:\n      one: {of: limb, " + keys(inner) +
        "}\ninstances:\n  it: {of: pair, " + keys(outer) + "}\n";
    // The composition: mirror first, then rotate, then move, twice.
    const auto matrix = [](const Place& p) {
      Eigen::Vector3d signs = Eigen::Vector3d::Ones();
      for (const char c : p.mirror)
        if (c >= 'x' && c <= 'z' && p.mirror != "none") signs[c - 'x'] = -1;
      return Eigen::Matrix3d(Eigen::AngleAxisd(p.rotate.norm(), p.rotate.normalized()).toRotationMatrix() *
                             signs.asDiagonal());
    };
    const Eigen::Matrix3d whole = matrix(outer) * matrix(inner);
    const Eigen::Vector3d at = matrix(outer) * inner.at + outer.at;
    // The same mirror in the end, whichever it is; the rest is a rotation.
    Eigen::Vector3d signs = Eigen::Vector3d::Ones();
    std::string mirror;
    for (int k = 0; k < 3; ++k) {
      const char axis = static_cast<char>('x' + k);
      const bool a = inner.mirror != "none" && inner.mirror.find(axis) != std::string::npos;
      const bool b = outer.mirror != "none" && outer.mirror.find(axis) != std::string::npos;
      if (a != b) signs[k] = -1, mirror += axis;
    }
    const Eigen::AngleAxisd turn(Eigen::Matrix3d(whole * signs.asDiagonal()));
    const Place flat{at, turn.angle() * turn.axis(), mirror.empty() ? "none" : mirror};
    const std::string written =
        "mimbre: 1\nbodies:\n  base: {mass: 3, com: [0, 0, 0], inertia: [1, 1, 1]}\nsubsystems:\n  limb:" +
        content + "instances:\n  it: {of: limb, " + keys(flat) + "}\n";
    const spec::Model a = read(nested), b = read(written);
    expect_equal(a, b, 1e-13);
    EXPECT_EQ(a.bodies[1].name, "it.one.arm");
    const auto x = channels_after(a, 5), y = channels_after(b, 5);
    ASSERT_EQ(x.size(), y.size());
    for (std::size_t k = 0; k < x.size(); ++k) EXPECT_NEAR(x[k], y[k], 1e-7 * (1 + std::abs(y[k])));
  }
}

TEST(NestedTemplates, AParameterThatIsANameCanBePassedOn) {
  const spec::Model model = read(R"yaml(mimbre: 1
bodies:
  base: {mass: 9, com: [0, 0, 0], inertia: [1, 1, 1]}
  other: {mass: 9, com: [0, 0, 0], inertia: [1, 1, 1]}
joints:
  a: {type: floating, between: [ground, base]}
  b: {type: floating, between: [ground, other]}
subsystems:
  inner:
    parameters: {on: {name: base}}
    bodies: {rim: {mass: 1, com: [0, 0, 0], inertia: [1, 1, 1]}}
    joints: {hub: {type: revolute, between: [$on, rim], at: [0, 0, 0], axis: [0, 1, 0]}}
  outer:
    parameters: {on: {name: base}}
    instances: {part: {of: inner, with: {on: $on}}}
instances:
  left: {of: outer}
  right: {of: outer, with: {on: other}}
)yaml");
  const auto carrier = [&](const std::string& name) {
    for (const spec::Joint& joint : model.joints)
      if (joint.name == name)
        return model
            .bodies[static_cast<std::size_t>(model.frames[static_cast<std::size_t>(joint.frame_a)].body)]
            .name;
    return std::string();
  };
  EXPECT_EQ(carrier("left.part.hub"), "base");
  EXPECT_EQ(carrier("right.part.hub"), "other");
}

TEST(NestedTemplates, NamesParametersAndMaterialsAreFoundFromInsideOut) {
  const spec::Model model = read(R"yaml(mimbre: 1
parameters: {m: 1}
bodies:
  base: {mass: 9, com: [0, 0, 0], inertia: [1, 1, 1]}
subsystems:
  axle:
    parameters: {m: 2, carrier: {name: base, about: what carries the axle}}
    bodies:
      beam: {mass: $m, com: [0, 0, 0], inertia: [1, 1, 1]}
    joints:
      mount: {type: fixed, between: [$carrier, beam]}
    subsystems:
      wheel:
        parameters: {on: {name: beam}}
        bodies: {rim: {mass: 10*m, com: [0, 1, 0], inertia: [1, 1, 1]}}
        joints: {spin: {type: revolute, between: [$on, rim], at: [0, 1, 0], axis: [0, 1, 0]}}
        outputs: [{name: "{instance}.spin", joint: spin}]
    instances:
      $side: {for: {side: [left, right]}, of: wheel, mirror: "$(side == right ? y : none)"}
instances:
  front: {of: axle}
  rear: {of: axle, at: [-2, 0, 0], with: {m: 3, carrier: front.left.rim}}
)yaml");
  const auto mass = [&](const std::string& name) {
    for (const spec::Body& body : model.bodies)
      if (body.name == name) return body.mass;
    ADD_FAILURE() << "no body " << name;
    return 0.0;
  };
  EXPECT_EQ(mass("front.beam"), 2);
  EXPECT_EQ(mass("front.left.rim"), 20);
  EXPECT_EQ(mass("rear.right.rim"), 30);
  const auto joined = [&](const std::string& name) {
    for (const spec::Joint& joint : model.joints)
      if (joint.name == name) {
        const auto body = [&](int frame) {
          const int index = model.frames[static_cast<std::size_t>(frame)].body;
          return index < 0 ? std::string("ground") : model.bodies[static_cast<std::size_t>(index)].name;
        };
        return body(joint.frame_a) + " " + body(joint.frame_b);
      }
    return std::string("none");
  };
  EXPECT_EQ(joined("front.mount"), "base front.beam");
  EXPECT_EQ(joined("rear.mount"), "front.left.rim rear.beam");
  EXPECT_EQ(joined("rear.right.spin"), "rear.beam rear.right.rim");
  ASSERT_EQ(model.outputs.size(), 4u);
  EXPECT_EQ(model.outputs[3].name, "rear.right.spin");
}

TEST(NestedTemplates, AMistakeIsSaidOnce) {
  const std::string text = R"yaml(mimbre: 1
subsystems:
  wheel:
    bodies: {rim: {mass: -1, com: [0, 0, 0], inertia: [1, 1, 1]}}
    joints: {spin: {type: revolute, between: [ground, rin], at: [0, 0, 0], axis: [0, 1, 0]}}
  axle:
    instances:
      left: {of: wheel}
      right: {of: wheel, mirrow: y}
instances:
  car$i: {for: {i: {from: 1, to: 40}}, of: axle}
)yaml";
  const auto all = mistakes(text);
  ASSERT_EQ(all.size(), 3u) << fmt::format("{}", fmt::join(all, "\n"));
  EXPECT_THAT(all[0], AllOf(HasSubstr("model.yaml:4:26: body 'car1.left.rim': mass: -1 is negative"),
                            HasSubstr("(likewise in car1.right, car2.left, "), HasSubstr("(79 in all)")));
  EXPECT_THAT(all[1], AllOf(HasSubstr("no body, frame or node 'rin' (did you mean 'rim'?)"),
                            HasSubstr("(79 in all)")));
  EXPECT_THAT(all[2],
              AllOf(HasSubstr("unknown key 'mirrow' (did you mean 'mirror'?)"), HasSubstr("(39 in all)")));
}

TEST(NestedTemplates, RecursionIsRefused) {
  EXPECT_THAT(
      mistake("mimbre: 1\nsubsystems: {a: {instances: {x: {of: a}}}}\ninstances: {y: {of: a}}\n"),
      AllOf(HasSubstr("model.yaml:2:"), HasSubstr("instance 'y.x': of: the subsystem 'a' stands in itself")));
  EXPECT_THAT(mistake("mimbre: 1\nsubsystems: {a: {instances: {x: {of: b}}}, b: {instances: {x: {of: "
                      "a}}}}\ninstances: {y: {of: a}}\n"),
              HasSubstr("stands in itself"));
  // Ten of ten of ten of …: as many values as the limit allows, and then an end.
  std::string text = "mimbre: 1\nsubsystems:\n";
  for (int k = 0; k < 9; ++k)
    text += fmt::format("  t{}: {{instances: {{x$i: {{for: {{i: {{from: 1, to: 10}}}}, of: t{}}}}}}}\n", k,
                        k + 1);
  text += "  t9: {bodies: {b: {mass: 1, com: [0, 0, 0], inertia: [1, 1, 1]}}}\ninstances: {y: {of: t0}}\n";
  EXPECT_THAT(mistakes(text).back(), HasSubstr("more than 500000 values together"));
}

TEST(NameParameters, SayWhatIsWrong) {
  const std::string rest = "bodies: {b: {mass: 1, com: [0, 0, 0], inertia: [1, 1, 1]}}\n";
  EXPECT_THAT(mistake("mimbre: 1\nparameters: {p: {name: b, value: 3}}\n" + rest),
              HasSubstr("a name has no 'value'"));
  EXPECT_THAT(mistake("mimbre: 1\nparameters: {p: {name: a b}}\n" + rest),
              HasSubstr("'a b' is no name of an item"));
  EXPECT_THAT(mistake("mimbre: 1\nparameters: {p: {name: none}}\n" + rest +
                      "joints: {j: {type: fixed, between: [ground, $p]}}\n"),
              HasSubstr("there is no body, frame or node 'none'"));
}

/// Files of a folder that goes with the test.
class Includes : public testing::Test {
 protected:
  Includes() { fs::create_directories(folder_ / "sub"); }
  ~Includes() override { fs::remove_all(folder_); }
  void file(const std::string& name, const std::string& text) const { std::ofstream(folder_ / name) << text; }
  std::string path(const std::string& name) const { return (folder_ / name).string(); }
  spec::Model load(const std::string& text) {
    file("model.yaml", text);
    return load_model(path("model.yaml"), {}, nullptr, &others_);
  }
  std::string refused(const std::string& text) {
    try {
      load(text);
    } catch (const InputError& error) {
      return error.what();
    }
    return "nothing is wrong";
  }

  fs::path folder_ = fs::path(testing::TempDir()) / fmt::format("mimbre_includes_{}", getpid());
  std::vector<std::string> others_;
};

constexpr const char* arm = "bodies:\n  arm: {mass: m, com: [0, 0, 0], inertia: [1, 1, 1]}\n";

TEST_F(Includes, StandBeforeWhatTheFileSays) {
  file("sub/values.yaml", "mimbre: 1\ntitle: Values\nparameters: {m: 4}\n");
  file("sub/parts.yaml", std::string("include: values.yaml\nparameters: {k: 2*m}\n") + arm +
                             "outputs: [{name: a, position: arm, component: x}]\n");
  const spec::Model model = load(
      "mimbre: 1\ntitle: Whole\ninclude: [sub/parts.yaml, sub/values.yaml]\nparameters: {c: k + 1}\n"
      "bodies:\n  leg: {mass: c, com: [0, 0, 0], inertia: [1, 1, 1]}\noutputs: [{name: b, position: leg, "
      "component: x}]\n");
  EXPECT_EQ(model.title, "Whole");
  ASSERT_EQ(model.bodies.size(), 2u);
  EXPECT_EQ(model.bodies[0].mass, 4);
  EXPECT_EQ(model.bodies[1].mass, 9);
  EXPECT_EQ(model.outputs.size(), 2u);
  EXPECT_EQ(others_.size(), 2u);
  // The results explain themselves: the texts of all files are in them.
  EXPECT_THAT(model.text, AllOf(HasSubstr("# parameters: {m: 4}"), HasSubstr("#   arm: {mass: m"),
                                HasSubstr("include: [sub/parts.yaml")));
}

TEST_F(Includes, OfTemplatesAndFilesOfTemplates) {
  file("sub/corner.yaml",
       "include: hub.yaml\nsubsystems: {bolt: {file: bolt.yaml}}\ninstances: {b: {of: bolt}}\n");
  file("sub/hub.yaml", "bodies: {hub: {mass: 1, com: [0, 0, 0], inertia: [1, 1, 1]}}\n");
  file("sub/bolt.yaml", "bodies: {bolt: {mass: 1, com: [0, 0, 0], inertia: [1, 1, 1]}}\n");
  const spec::Model model = load(
      "mimbre: 1\nsubsystems: {corner: {file: sub/corner.yaml}, other: {include: sub/hub.yaml}}\n"
      "instances: {left: {of: corner}, right: {of: corner}, o: {of: other}}\n");
  std::vector<std::string> names;
  for (const spec::Body& body : model.bodies) names.push_back(body.name);
  EXPECT_THAT(names, testing::ElementsAre("left.hub", "left.b.bolt", "right.hub", "right.b.bolt", "o.hub"));
  EXPECT_EQ(others_.size(), 4u) << "hub.yaml is read for each of the two that include it, the others once";
}

TEST_F(Includes, MistakesNameTheFileAndLine) {
  file("sub/parts.yaml",
       "parameters: {m: 1}\n\nbodies:\n  arm: {mass: -1, com: [0, 0, 0], inertia: [1, 1, 1]}\n");
  EXPECT_THAT(refused("mimbre: 1\ninclude: sub/parts.yaml\n"),
              HasSubstr(path("sub/parts.yaml") + ":4:15: body 'arm': mass: -1 is negative"));
  file("sub/parts.yaml", std::string("parameters: {m: 1}\n") + arm);
  EXPECT_THAT(refused(std::string("mimbre: 1\ninclude: sub/parts.yaml\n") + arm),
              HasSubstr(path("model.yaml") + ":4:3: 'arm' is given twice (first in " +
                        path("sub/parts.yaml") + ":3)"));
  EXPECT_THAT(refused("mimbre: 1\ninclude: sub/part.yaml\n"),
              AllOf(HasSubstr("model.yaml:2:10: include: there is no file"), HasSubstr("sub/part.yaml")));
  EXPECT_THAT(refused("mimbre: 1\ninclude: $p\n"), HasSubstr("without parameters"));
  file("sub/parts.yaml", "bodies: [\n");
  EXPECT_THAT(refused("mimbre: 1\ninclude: sub/parts.yaml\n"), HasSubstr(path("sub/parts.yaml") + ":"));
  file("sub/parts.yaml", "boddies: {}\n");
  EXPECT_THAT(refused("mimbre: 1\ninclude: sub/parts.yaml\n"),
              AllOf(HasSubstr("parts.yaml:1:1"), HasSubstr("did you mean 'bodies'")));
  EXPECT_THAT(mistake("mimbre: 1\ninclude: sub/parts.yaml\n"), HasSubstr("no folder"));
}

TEST_F(Includes, CirclesAreRefused) {
  EXPECT_THAT(refused("mimbre: 1\ninclude: ./model.yaml\n"), HasSubstr("model.yaml' includes itself"));
  file("sub/a.yaml", "include: b.yaml\n");
  file("sub/b.yaml", "include: ../sub/a.yaml\n");
  EXPECT_THAT(refused("mimbre: 1\ninclude: sub/a.yaml\n"),
              AllOf(HasSubstr("b.yaml:1:10"), HasSubstr("includes itself by way of others")));
  file("sub/t.yaml", "subsystems: {t: {file: t.yaml}}\ninstances: {i: {of: t}}\n");
  EXPECT_THAT(refused("mimbre: 1\nsubsystems: {t: {file: sub/t.yaml}}\ninstances: {i: {of: t}}\n"),
              HasSubstr("stands in itself"));
}

/// A ball on a slope, a block and a rock of its own, in each place what it is in the other: a mirror is no
/// more than one. The block has no place but its body's.
TEST(Templates, CarrySurfacesAndContacts) {
  const std::string content = R"y(
gravity: [0, 0, 0]
subsystems:
  drop:
    bodies:
      ball: {mass: 1, com: [0.1, 0.2, 0.5], inertia: [0.004, 0.004, 0.004]}
      block: {mass: 3, com: [0.6, 0.3, 0], inertia: [1, 1, 1]}
    joints:
      free: {type: floating, between: [ground, ball], at: [0.1, 0.2, 0.5]}
      slide: {type: prismatic, between: [ground, block], at: [0.6, 0.3, 0], axis: [0.6, 0, 0.8], spring: {stiffness: 500}}
    loads: {weight: {on: ball, at: [0.1, 0.2, 0.5], force: [5, 1.5, -9.81]}}
    surfaces:
      slope: {type: half_space, z: [0.3, -0.1, 1]}
      block: {type: box, on: block, size: [0.4, 0.3, 0.2], x: [1, 0.2, 0]}
      rock: {type: mesh, at: [0.3, 0.2, 0.1], vertices: [[0.2, 0, 0], [-0.2, 0.2, 0], [-0.2, -0.2, 0], [0, 0, 0.2]], triangles: [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]]}
    contacts:
      touch: {spheres: {on: ball, radius: 0.1}, surfaces: [slope, block, rock, wall], stiffness: 1e4, restitution: 0.5, friction: 0.3}
    outputs:
      - {name: "{instance}.x", position: ball, component: x}
      - {name: "{instance}.y", position: ball, component: y}
      - {name: "{instance}.z", position: ball, component: z}
instances:
  as_drawn: {of: drop}
  at_x: {of: drop, mirror: x, at: [10, 0, 0]}
  at_y: {of: drop, mirror: y, at: [0, 10, 0]}
  at_z: {of: drop, mirror: z, at: [0, 0, 10]}
  at_all: {of: drop, mirror: xyz, at: [10, 10, 10]}
surfaces: {wall: {type: half_space, at: [0, 0, -100]}}
contacts: {outside: {spheres: {on: as_drawn.ball, radius: 0.1}, surfaces: at_z.slope, stiffness: 1e4}}
simulation: {step: 0.001, end: 1}
)y";
  const std::vector<double> at = channels_after(read("mimbre: 1\n" + content), 400);
  ASSERT_GE(at.size(), 15u);
  const Eigen::Vector3d drawn(at[0], at[5], at[10]),
      free = Eigen::Vector3d(0.1, 0.2, 0.5) + 0.5 * 0.16 * Eigen::Vector3d(5, 1.5, -9.81);
  EXPECT_GT((drawn - free).norm(), 0.2) << "it touched nothing";
  const Eigen::Vector3d mirrors[] = {{-1, 1, 1}, {1, -1, 1}, {1, 1, -1}, {-1, -1, -1}},
                        moves[] = {{10, 0, 0}, {0, 10, 0}, {0, 0, 10}, {10, 10, 10}};
  for (std::size_t k = 0; k < 4; ++k) {
    const Eigen::Vector3d here(at[k + 1], at[k + 6], at[k + 11]);  // x of all instances, y, z
    EXPECT_LT((here - mirrors[k].cwiseProduct(drawn) - moves[k]).norm(), 1e-7) << k;
  }
}

/// A bushing to the ground whose axes are not given has those of its part, turned and mirrored with it: under
/// a load along the part's x each moves by that over the first stiffness.
TEST(Templates, BushingsToTheGroundTurnWithTheirPart) {
  const std::vector<double> at = channels_after(read(R"y(mimbre: 1
gravity: [0, 0, 0]
subsystems:
  part:
    bodies: {b: {mass: 1, com: [0, 0, 0], inertia: [1, 1, 1]}}
    bushings:
      u: {between: [ground, b], at: [0, 0, 0], stiffness: [100, 1000, 10000, 1000, 1000, 1000],
        damping: [20, 60, 200, 60, 60, 60]}
    loads: {l: {on: b, at: [0, 0, 0], force: [1, 0, 0]}}
    outputs:
      - {name: "{instance}.x", position: b, component: x}
      - {name: "{instance}.y", position: b, component: y}
instances:
  drawn: {of: part}
  turned: {of: part, rotate: [0, 0, pi/2]}
  mirrored: {of: part, rotate: [0, 0, pi/2], mirror: y}
simulation: {step: 0.01, end: 20}
)y"),
                                                2000);
  const double x[] = {0.01, 0, 0}, y[] = {0, 0.01, 0.01};
  for (std::size_t k = 0; k < 3; ++k) {  // x of all instances, then y
    EXPECT_NEAR(at[k], x[k], 1e-9) << k;
    EXPECT_NEAR(std::abs(at[3 + k]), y[k], 1e-9) << k;
  }
}

}  // namespace
}  // namespace mimbre::templates_test
