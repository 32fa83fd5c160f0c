#include "mimbre/diagnostics.h"
#include "spec/force_law.h"
#include "spec/model_builder_parts.h"

/// Inputs, signals and force elements by names.
namespace mimbre {

void ModelBuilder::add_input(const std::string& name, const build::Input& given) {
  Addition addition(*impl_, impl_->inputs, name);
  spec::Input input;
  input.name = name;
  input.unit = given.unit;
  input.start = given.start;
  input.min = given.min;
  input.max = given.max;
  input.hold = given.hold;
  input.tunable = given.tunable;
  addition.commit(impl_->inputs, impl_->model.inputs.size());
  impl_->model.inputs.push_back(std::move(input));
}

std::vector<spec::Law> Addition::formulas(const char* what, const std::vector<std::string>& texts,
                                          const std::vector<std::string>& of) {
  using Kind = spec::Source::Kind;
  ModelBuilder::Impl& b = builder_;
  std::vector<std::string> seen;
  std::vector<spec::Source> sources;
  for (const std::string& name : of) {
    if (name == "t") {
      sources.emplace_back();
    } else if (const auto input = b.inputs.index.find(name); input != b.inputs.index.end()) {
      sources.push_back({Kind::input, input->second});
    } else if (const auto other = b.signals.index.find(name); other != b.signals.index.end()) {
      sources.push_back({Kind::signal, other->second});
    } else {
      const int output = find(b.outputs, "of", name);
      const auto known = b.sensors.find(name);
      const int sensor =
          known != b.sensors.end() ? known->second : static_cast<int>(b.model.sensors.size() + seen.size());
      if (known == b.sensors.end()) seen.push_back(b.model.outputs[static_cast<std::size_t>(output)].name);
      sources.push_back({Kind::sensor, sensor});
    }
  }
  std::vector<spec::Law> laws;
  try {
    for (const std::string& text : texts) laws.push_back({Formula::expression(text, of), sources});
  } catch (const InputError& error) {  // which does not know of whose formula it speaks
    refuse(fmt::format("{}: {}", what, error.diagnostics().front().message));
  }
  for (const std::string& output : seen) {
    b.sensors[output] = static_cast<int>(b.model.sensors.size());
    b.model.sensors.push_back(b.model.outputs[static_cast<std::size_t>(b.outputs.index.at(output))]);
  }
  return laws;
}

void ModelBuilder::add_signal(const std::string& name, const build::Signal& given) {
  Addition addition(*impl_, impl_->signals, name);
  spec::Signal signal;
  signal.name = name;
  signal.unit = given.unit;
  signal.every = given.every;
  signal.law = std::move(addition.formulas("value", {given.value}, given.of).front());
  addition.commit(impl_->signals, impl_->model.signals.size());
  impl_->model.signals.push_back(std::move(signal));
}

void ModelBuilder::add_element(const std::string& name, const build::Element& given) {
  Addition addition(*impl_, impl_->elements, name);
  addition.coordinates_of(given.in);
  spec::Element e;
  e.name = name;
  e.law = given.law;
  if (find_law(given.law) < 0) {
    std::vector<std::string> known;
    for (const LawInfo* law : all_laws())
      if (law->along || law->coordinate || law->relative || !law->section.empty())
        known.emplace_back(law->name);
    addition.refuse(fmt::format("there is no law '{}'{}", given.law, did_you_mean(given.law, known)));
  }
  const bool six = given.all_six || given.law == "bushing";
  const bool between = !given.between[0].empty() || !given.between[1].empty();
  if ((!given.joint.empty() || between ? 1 : 0) + (given.terms.empty() ? 0 : 1) +
          (given.over.empty() ? 0 : 1) + (given.on.empty() ? 0 : 1) >
      1)
    addition.refuse(
        "acts on a 'joint', 'between' two, on 'terms', 'over' points or 'on' one; give one of these");
  if (!given.terms.empty()) {
    e.on = spec::Element::On::coordinates;
    for (const auto& term : given.terms)
      e.terms.push_back({addition.find(impl_->joints, "terms", term.joint), term.coordinate, term.factor});
  } else if (!given.over.empty()) {
    e.on = spec::Element::On::path;
    for (std::size_t k = 0; k < given.over.size(); ++k)
      e.path.push_back(addition.attach("over", given.over[k],
                                       k < given.places.size() ? given.places[k] : std::nullopt,
                                       fmt::format("{}.{}", name, k + 1)));
  } else if (!given.on.empty()) {
    e.on = spec::Element::On::velocity;
    e.frame_b = addition.attach("on", given.on, given.at[0], name + ".frame");
  } else if (!given.joint.empty()) {
    if (!given.between[0].empty() || !given.between[1].empty() || six || given.along || given.about)
      addition.refuse(
          "acts on a joint, so that 'between', 'along', 'about' and 'all_six' do not belong here");
    e.on = spec::Element::On::coordinate;
    e.joint = addition.find(impl_->joints, "joint", given.joint);
    e.coordinate = given.coordinate;
  } else {
    if ((given.along ? 1 : 0) + (given.about ? 1 : 0) + (six ? 1 : 0) > 1)
      addition.refuse("acts along a direction, about one, or in all six components; give one of these");
    e.frame_a = addition.attach("between", given.between[0], given.at[0], name + ".a");
    e.frame_b = addition.attach("between", given.between[1], given.at[1], name + ".b");
    e.on = six                            ? spec::Element::On::frames
           : (given.along || given.about) ? spec::Element::On::axis
                                          : spec::Element::On::line;
    e.about = given.about.has_value();
    if (e.on == spec::Element::On::axis)
      e.direction = addition.frame_pose(e.frame_a).rotation.transpose() *
                    addition.direction(e.about ? "about" : "along", e.about ? *given.about : *given.along);
  }
  for (const std::string& signal : given.signals)
    e.arguments.push_back({spec::Source::Kind::signal, addition.find(impl_->signals, "signals", signal)});
  e.numbers = given.numbers;
  if (given.law == "bushing" && e.numbers.empty())
    for (const auto* matrix : {&given.stiffness, &given.damping})
      for (int r = 0; r < 6; ++r)
        for (int c = 0; c < 6; ++c) e.numbers.push_back((*matrix)(r, c));
  e.functions = given.functions;
  e.branches = given.branches;
  e.user = given.user;
  addition.commit(impl_->elements, impl_->model.elements.size());
  impl_->model.elements.push_back(std::move(e));
}

}  // namespace mimbre
