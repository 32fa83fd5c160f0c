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

}  // namespace mimbre::test
