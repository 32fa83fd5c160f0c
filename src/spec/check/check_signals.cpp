#include <algorithm>
#include <cmath>

#include "joints/joint_kind.h"
#include "spec/block_info.h"
#include "spec/check/checked_item.h"
#include "spec/force_law.h"
#include "spec/nearest_place.h"

/// Inputs, signals, and the force elements that have no section of their own.
namespace mimbre::checks {
namespace {

void check_source(const spec::Model& model, const CheckedItem& item, const spec::Source& source) {
  using Kind = spec::Source::Kind;
  switch (source.kind) {
    case Kind::time:
      return;
    case Kind::input:
      item.index("argument", source.index, model.inputs.size(), "inputs");
      return;
    case Kind::signal:
      item.index("argument", source.index, model.signals.size(), "signals");
      return;
    case Kind::sensor:
      item.index("argument", source.index, model.sensors.size(), "sensors");
      return;
  }
  item.error(
      fmt::format("an argument's kind is {}, which is none of its choices", static_cast<int>(source.kind)));
}

void check_coordinate(const spec::Model& model, const CheckedItem& item, int joint, int coordinate) {
  if (!item.index("joint", joint, model.joints.size(), "joints")) return;
  const spec::JointType type = model.joints[static_cast<std::size_t>(joint)].type;
  if (!is_joint(type)) return;  // reported already
  const JointInfo& info = joint_info(type);
  const int count = info.quaternion < 0 ? info.velocities : info.rotation;
  if (count == 0)
    item.error(fmt::format("a {} joint has no scalar coordinate to act on", info.name));
  else
    item.between("coordinate", coordinate, 0, count - 1);
}

void check_terms(const spec::Model& model, const CheckedItem& item, const spec::Element& e) {
  if (e.terms.empty()) item.error("is on no coordinate; give it terms, a joint and a factor each");
  for (const spec::Element::Term& term : e.terms) {
    check_coordinate(model, item, term.joint, term.coordinate);
    if (item.finite("factor", term.factor) && term.factor == 0)
      item.error("the factor of a coordinate is 0, by which it does nothing there; leave it out");
  }
}

void check_path(const spec::Model& model, const CheckedItem& item, const std::vector<int>& path) {
  if (path.size() < 2)
    return item.error(fmt::format("runs over {} frames; two at least are needed", path.size()));
  bool sound = true, moves = false;
  for (const int frame : path)
    sound = item.index("path", frame, model.frames.size(), "frames") && sound_frame(model, frame) && sound;
  if (!sound) return;
  const auto at = [&](std::size_t k) -> const spec::Frame& {
    return model.frames[static_cast<std::size_t>(path[k])];
  };
  for (std::size_t k = 0; k < path.size(); ++k) {
    moves = moves || at(k).body != at(0).body;
    if (k > 0 && assembled_place(model, at(k - 1)) == assembled_place(model, at(k)))
      item.error(
          fmt::format("its points {} and {} are at one place in the assembled position: there is no "
                      "direction between them; move one",
                      k, k + 1));
  }
  if (!moves) item.error("has all of its points on one body, where it does nothing");
}

void check_place(const spec::Model& model, const CheckedItem& item, const spec::Element& e) {
  using On = spec::Element::On;
  if (!item.enumerator("on", e.on, 7)) return;
  if (e.on == On::coordinate) return check_coordinate(model, item, e.joint, e.coordinate);
  if (e.on == On::coordinates) return check_terms(model, item, e);
  if (e.on == On::path) return check_path(model, item, e.path);
  if (e.on == On::velocity) {
    if (item.index("frame_b", e.frame_b, model.frames.size(), "frames") && sound_frame(model, e.frame_b) &&
        model.frames[static_cast<std::size_t>(e.frame_b)].body == spec::ground)
      item.error("is on the ground, which it cannot move; give it a frame on a body");
    return;
  }
  const bool a = item.index("frame_a", e.frame_a, model.frames.size(), "frames");
  const bool b = item.index("frame_b", e.frame_b, model.frames.size(), "frames");
  if (!a || !b || !sound_frame(model, e.frame_a) || !sound_frame(model, e.frame_b)) return;
  const spec::Frame &first = model.frames[static_cast<std::size_t>(e.frame_a)],
                    &second = model.frames[static_cast<std::size_t>(e.frame_b)];
  if (first.body == spec::ground && second.body == spec::ground) item.error("both ends are on the ground");
  if (e.on == spec::Element::On::line &&
      at_one_place(assembled_place(model, first), assembled_place(model, second)))
    item.error("has length 0 in the assembled position: its direction is not defined; move one end");
  if (e.on == spec::Element::On::axis && item.finite("direction", e.direction) && e.direction.isZero(0))
    item.error("direction has no length; give a vector such as (0, 0, 1)");
}

void check_functions(const CheckedItem& item, const spec::Element& e, const LawInfo& law) {
  const std::size_t given = e.functions.size();
  if (given != 0 && static_cast<int>(given) != law.functions)
    return item.error(law.functions == 0 ? fmt::format("law '{}' has no functions", law.name)
                                         : fmt::format("law '{}' has {} functions, {} are given", law.name,
                                                       law.functions, given));
  if (!e.general.formula.is_zero() && !law.of_functions)
    item.error(fmt::format("law '{}' has no formula 'general'; torsion springs have", law.name));
}

void check_element(const spec::Model& model, const CheckedItem& item, const spec::Element& e) {
  const int row = find_law(e.law);
  std::string known;
  for (const LawInfo* info : all_laws())
    if (info->coordinate || info->relative || !info->section.empty())
      known += fmt::format("{}'{}'", known.empty() ? "" : ", ", info->name);
  if (row < 0) return item.error(fmt::format("there is no law '{}'; there are {}", e.law, known));
  const LawInfo& law = law_info(row);
  using On = spec::Element::On;
  const bool fits = (e.on == On::line && law.along) || (e.on == On::coordinate && law.coordinate) ||
                    (e.on == On::axis && law.axis) || (e.on == On::frames && law.relative) ||
                    (e.on == On::coordinates && law.coordinates) || (e.on == On::path && law.path) ||
                    (e.on == On::velocity && law.velocity);
  if (!fits) item.error(fmt::format("law '{}' does not act there; there are {}", e.law, known));
  check_place(model, item, e);
  for (std::size_t k = 0; k < e.numbers.size(); ++k) {
    const bool by_default = k < law.numbers.size() && e.numbers[k] == law.numbers[k].otherwise;
    if (!by_default && !item.finite("one of numbers", e.numbers[k])) break;
  }
  for (const spec::Source& source : e.arguments) check_source(model, item, source);
  const bool user = e.law == "user", bushing = e.law == "bushing";
  const bool takes_none = law.optional && e.arguments.empty();
  if (!takes_none && (user ? e.arguments.size() > 64 : static_cast<int>(e.arguments.size()) != law.arguments))
    item.error(fmt::format("law '{}' takes {} signals, {} are given", e.law, user ? 64 : law.arguments,
                           e.arguments.size()));
  if (user != static_cast<bool>(e.user))
    item.error(user ? "has no function: set 'user'"
                    : "has a function of the user's, which belongs to law 'user'");
  if (e.user && !e.user->evaluate) item.error("has an empty function");
  if (e.user && e.user->states.size() > 64)
    item.error(fmt::format("has {} states; a law of the user's has at most 64", e.user->states.size()));
  if (e.user)
    for (const double state : e.user->states) item.finite("one of its states", state);
  if (!bushing && !user && e.numbers.size() != law.numbers.size())
    item.error(
        fmt::format("law '{}' has {} numbers, {} are given", e.law, law.numbers.size(), e.numbers.size()));
  for (std::size_t k = 0; !bushing && k < std::min(e.numbers.size(), law.numbers.size()); ++k)
    if (const LawNumber& number = law.numbers[k]; !number.allows(e.numbers[k]))
      item.error(fmt::format("{} {}", number.key, wrong_number(number, e.numbers[k])));
  if (law.fault && e.numbers.size() == law.numbers.size())
    if (const std::string_view fault = law.fault(e.numbers); !fault.empty()) item.error(std::string(fault));
  check_functions(item, e, law);
  std::vector<std::string> faults;
  if (law.check) law.check(e, faults);
  for (const std::string& fault : faults) item.error(fault);
  if (!e.branches.empty() && !bushing) item.error("branches belong to a bushing");
  for (const spec::MaxwellBranch& branch : e.branches) {
    item.positive("relaxation", branch.relaxation);
    if (item.finite("stiffness of a branch", branch.stiffness) &&
        !branch.stiffness.isApprox(branch.stiffness.transpose(), 1e-9))
      item.error("stiffness of a branch is not symmetric");
  }
}

}  // namespace

void check_law(const spec::Model& model, const CheckedItem& item, const spec::Law& law, std::size_t own) {
  if (law.formula.is_zero()) return;
  for (const spec::Source& source : law.arguments) check_source(model, item, source);
  if (law.formula.variables() != own + law.arguments.size())
    item.error(fmt::format("its formula has {} variables; {} of its own and {} arguments are given",
                           law.formula.variables(), own, law.arguments.size()));
}

void check_inputs(const spec::Model& model, std::vector<Diagnostic>& errors) {
  for (std::size_t k = 0; k < model.inputs.size(); ++k) {
    const spec::Input& input = model.inputs[k];
    const CheckedItem item(errors, "input", input.name, input.mark, k);
    item.enumerator("hold", input.hold, 2);
    item.finite("start", input.start);
    if (!(input.min <= input.max))
      item.error(fmt::format("its range from {} to {} is empty", input.min, input.max));
    else if (!(input.start >= input.min && input.start <= input.max))
      item.error(
          fmt::format("start is {}, outside of its range from {} to {}", input.start, input.min, input.max));
  }
}

void check_signals(const spec::Model& model, std::vector<Diagnostic>& errors) {
  for (std::size_t k = 0; k < model.signals.size(); ++k) {
    const spec::Signal& signal = model.signals[k];
    const CheckedItem item(errors, "signal", signal.name, signal.mark, k);
    item.not_negative("every", signal.every);
    if (signal.block != -1) {
      if (item.index("block", signal.block, model.blocks.size(), "blocks"))
        item.between("output", signal.output, 0,
                     output_count(model.blocks[static_cast<std::size_t>(signal.block)]) - 1);
      continue;
    }
    if (signal.law.formula.is_zero()) item.error("has no formula");
    check_law(model, item, signal.law, 0);
  }
  for (std::size_t k = 0; k < model.springs.size(); ++k)
    check_law(model, CheckedItem(errors, "spring", model.springs[k].name, model.springs[k].mark, k),
              model.springs[k].general, 2);
  for (std::size_t k = 0; k < model.joints.size(); ++k) {
    const CheckedItem item(errors, "joint", model.joints[k].name, model.joints[k].mark, k);
    for (const spec::JointSpring& spring : model.joints[k].springs) check_law(model, item, spring.general, 2);
    for (const spec::Drive& drive : model.joints[k].drives)
      if (drive.signal >= 0) item.index("drive: signal", drive.signal, model.signals.size(), "signals");
  }
}

void check_elements(const spec::Model& model, std::vector<Diagnostic>& errors) {
  for (std::size_t k = 0; k < model.elements.size(); ++k) {
    const spec::Element& e = model.elements[k];
    const CheckedItem item(errors, "element", e.name, e.mark, k);
    check_element(model, item, e);
    check_law(model, item, e.general, 2);
  }
}

}  // namespace mimbre::checks
