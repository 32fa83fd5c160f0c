#include "portable/fmu/terminals.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <zlib.h>

#include <algorithm>
#include <pugixml.hpp>
#include <set>

#include "portable/fmu/canvas.h"
#include "portable/fmu/icon.h"
#include "support/models.h"

/// Terminals of FMUs at the parts of a model, and their drawings.
namespace mimbre::test::fmu_terminals_test {
namespace {

using portable::Terminal;

/// An arm that a servo turns, with a tip, and a brake that two joints share.
constexpr const char* arm = R"yaml(
inputs: {wanted: {start: 0.2, range: [-1, 1]}, push: {start: 0}, brake: {start: 0}, unused: {start: 1}}
parameters: {stiffness: {value: 3, tunable: true}}
bodies:
  arm: {mass: 1, inertia: [0.1, 0.1, 0.1], com: [0.5, 0, 0]}
  hand: {mass: 0.5, inertia: [0.1, 0.1, 0.1], com: [1.2, 0, 0]}
frames: {tip: {body: arm, at: [1, 0, 0]}}
joints:
  shoulder: {type: revolute, between: [ground, arm], at: [0, 0, 0], axis: [0, 1, 0]}
  wrist: {type: revolute, between: [arm, hand], at: [1, 0, 0], axis: [0, 1, 0]}
signals:
  angle: {joint: shoulder}
  servo: {pid: angle, setpoint: wanted, kp: 2, ki: 3}
actuators:
  motor: {joint: shoulder, torque: servo - brake}
  wrist_motor: {joint: wrist, torque: push - brake - stiffness*0.1}
outputs:
  - {name: shoulder.angle, joint: shoulder}
  - {name: shoulder.rate, joint_velocity: shoulder}
  - {name: tip.z, position: tip, component: z}
  - {name: tip.x, position: tip, component: x}
  - {name: tip.y, position: arm, at: [1, 0, 0], component: y}
  - {name: vz, velocity: tip, component: z}
  - {name: reaction.fx, joint_force: wrist, component: fx}
  - {name: again, joint: shoulder}
)yaml";

FmuCode fmu_of(const std::shared_ptr<const Model>& model, int version) {
  FmuOptions options;
  options.version = version;
  options.name = "arm";
  options.with_library = true;  // has all outputs
  return generate_fmu(model, {}, options);
}

std::vector<std::string> names_of(const std::vector<Terminal>& terminals) {
  std::vector<std::string> out;
  for (const Terminal& t : terminals) out.push_back(t.name);
  return out;
}
const Terminal& named(const std::vector<Terminal>& terminals, const std::string& name) {
  for (const Terminal& t : terminals)
    if (t.name == name) return t;
  throw std::runtime_error("no terminal " + name);
}

using Members = std::vector<std::pair<std::string, std::string>>;

TEST(FmuTerminals, BelongToThePartsOfTheModel) {
  const auto model = model_of(arm);
  const std::vector<Terminal> all = portable::fmu_terminals(fmu_of(model, 3), model->spec());
  EXPECT_THAT(names_of(all), testing::UnorderedElementsAre("joint.shoulder", "joint.wrist", "frame.tip"));
  // The brake acts on both joints, and is in neither terminal; nor are parameters.
  const Terminal& shoulder = named(all, "joint.shoulder");
  EXPECT_EQ(shoulder.members, (Members{{"wanted", "wanted"},
                                       {"position", "shoulder.angle"},
                                       {"velocity", "shoulder.rate"},
                                       {"again", "again"}}));
  EXPECT_EQ(shoulder.rule, "bus");
  EXPECT_TRUE(shoulder.takes);
  EXPECT_EQ(named(all, "joint.wrist").members, (Members{{"push", "push"}, {"force.x", "reaction.fx"}}));
  const Terminal& tip = named(all, "frame.tip");
  EXPECT_FALSE(tip.takes);
  EXPECT_EQ(tip.members, (Members{{"velocity.z", "vz"}}));
  ASSERT_EQ(tip.inner.size(), 1u);
  EXPECT_EQ(tip.inner[0].name, "position");
  EXPECT_EQ(tip.inner[0].rule, "plug");
  EXPECT_EQ(tip.inner[0].members, (Members{{"x", "tip.x"}, {"y", "tip.y"}, {"z", "tip.z"}}));
}

/// The rules of the standard: unique names, variables that exist and are inputs, outputs or parameters.
void check_terminals(const pugi::xml_node list, const std::set<std::string>& variables) {
  std::set<std::string> names;
  for (const pugi::xml_node t : list.children("Terminal")) {
    EXPECT_TRUE(names.insert(t.attribute("name").value()).second);
    EXPECT_THAT(t.attribute("matchingRule").value(),
                testing::AnyOf(testing::StrEq("plug"), testing::StrEq("bus")));
    std::set<std::string> members;
    for (const pugi::xml_node m : t.children("TerminalMemberVariable")) {
      EXPECT_TRUE(members.insert(m.attribute("memberName").value()).second);
      EXPECT_TRUE(variables.contains(m.attribute("variableName").value()));
      EXPECT_STREQ(m.attribute("variableKind").value(), "signal");
    }
    check_terminals(t, variables);
  }
}

TEST(FmuTerminals, AreDescribedAsTheStandardWantsThem) {
  for (const int version : {2, 3})
    for (const auto& model : {model_of(arm), controlled_four_bar(), example("iltis/drive.yaml"),
                              example("tutorial/pendulum.yaml"), example("ball-cascade/model.yaml")}) {
      SCOPED_TRACE(model->spec().title);
      const FmuCode fmu = fmu_of(model, version);
      std::set<std::string> variables;
      for (const FmuVariable& v : fmu.variables)
        if (v.role != FmuVariable::Role::time) variables.insert(v.name);
      pugi::xml_document document;
      ASSERT_TRUE(document.load_string(
          portable::terminals_description(portable::fmu_terminals(fmu, model->spec())).c_str()));
      const pugi::xml_node root = document.child("fmiTerminalsAndIcons");
      EXPECT_STREQ(root.attribute("fmiVersion").value(), "3.0");
      EXPECT_TRUE(root.child("GraphicalRepresentation").child("Icon"));
      EXPECT_TRUE(root.child("Terminals").first_child());
      check_terminals(root.child("Terminals"), variables);
    }
}

/// Width, height, and the bytes of all pixels of a PNG with rows that have no filter.
std::string pixels_of(const std::string& png, std::size_t width) {
  EXPECT_EQ(png.substr(0, 8), "\x89PNG\r\n\x1a\n");
  const std::size_t at = png.find("IDAT");
  const auto byte = [&](std::size_t k) {
    return static_cast<std::size_t>(static_cast<unsigned char>(png[k]));
  };
  const std::size_t size = byte(at - 4) << 24 | byte(at - 3) << 16 | byte(at - 2) << 8 | byte(at - 1);
  EXPECT_EQ(byte(16) << 24 | byte(17) << 16 | byte(18) << 8 | byte(19), width);
  const auto sum = crc32(0, reinterpret_cast<const Bytef*>(png.data()) + at, static_cast<uInt>(size + 4));
  EXPECT_EQ(
      byte(at + 4 + size) << 24 | byte(at + 5 + size) << 16 | byte(at + 6 + size) << 8 | byte(at + 7 + size),
      sum);
  std::string out(width * (4 * width + 1), '\0');
  uLongf room = out.size();
  EXPECT_EQ(uncompress(reinterpret_cast<Bytef*>(out.data()), &room,
                       reinterpret_cast<const Bytef*>(png.data()) + at + 4, size),
            Z_OK);
  EXPECT_EQ(room, out.size());
  return out;
}

/// The opacity of all pixels together, in pixels: the area of what is drawn.
double area_of(const portable::Canvas& canvas) {
  const std::size_t n = static_cast<std::size_t>(canvas.pixels);
  const std::string pixels = pixels_of(portable::png_of(canvas), n);
  double area = 0;
  for (std::size_t j = 0; j < n; ++j)
    for (std::size_t i = 0; i < n; ++i)
      area += static_cast<unsigned char>(pixels[j * (4 * n + 1) + 1 + 4 * i + 3]) / 255.0;
  return area;
}

TEST(FmuIcons, CoverTheAreaOfWhatTheyDraw) {
  portable::Canvas canvas;
  canvas.strokes = {{{100, 120}, {100, 120}, 40, 0, {200, 10, 30}}};
  EXPECT_NEAR(area_of(canvas), M_PI * 40 * 40, 15);
  canvas.strokes = {{{50, 60}, {170, 220}, 0, 6, {200, 10, 30}}};
  EXPECT_NEAR(area_of(canvas), 200 * 6 + M_PI * 9, 15);
  canvas.strokes = {{{128, 128}, {128, 128}, 60, 4, {200, 10, 30}}};
  EXPECT_NEAR(area_of(canvas), 2 * M_PI * 60 * 4, 20);
  // Beyond the edge nothing is drawn.
  canvas.strokes = {{{-500, -500}, {900, -400}, 0, 6, {200, 10, 30}},
                    {{0, 128}, {-90, 128}, 0, 2, {0, 0, 0}}};
  EXPECT_LT(area_of(canvas), 12);
}

TEST(FmuIcons, AreThereForEveryModel) {
  for (const auto& model :
       {model_of(arm), example("iltis/vehicle.yaml"), every_constraint(), die_and_ball()}) {
    const portable::Icon icon = portable::model_icon(model->spec());
    EXPECT_THAT(icon.svg, testing::StartsWith("<svg "));
    EXPECT_THAT(icon.svg, testing::Not(testing::HasSubstr("nan")));
    pugi::xml_document document;
    EXPECT_TRUE(document.load_string(icon.svg.c_str()));
    const std::string pixels = pixels_of(icon.png, 256);
    EXPECT_GT(std::count_if(pixels.begin(), pixels.end(), [](char c) { return c != 0; }), 500);
    EXPECT_EQ(portable::model_icon(model->spec()).png, icon.png);
  }
}

}  // namespace
}  // namespace mimbre::test::fmu_terminals_test
