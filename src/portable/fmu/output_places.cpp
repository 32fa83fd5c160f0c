#include "portable/fmu/output_places.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <span>
#include <tuple>

#include "joints/joint_kind.h"
#include "spec/output_kind.h"

namespace mimbre::portable {
namespace {

template <class List>
ModelPlace place_in(const List& list, int item, const char* kind) {
  if (item < 0 || item >= static_cast<int>(list.size())) return {};
  const std::string& name = list[static_cast<std::size_t>(item)].name;
  return {fmt::format("{}.{}", kind, name), kind, fmt::format("{} '{}'", kind, name)};
}

/// The name without its last letter, and without what separates that from the rest.
std::string stem_of(std::string name) {
  if (!name.empty()) name.pop_back();
  while (!name.empty() && (name.back() == '.' || name.back() == '_' || name.back() == ' ')) name.pop_back();
  return name;
}

/// "tip" of an output tip.z, for the point where it is.
std::string point_of(const std::string& output) {
  const std::size_t last = output.size() - 1;
  const bool component = output.size() > 2 && std::string("xyz").find(output[last]) != std::string::npos &&
                         std::string("._ ").find(output[last - 1]) != std::string::npos;
  return component ? stem_of(output) : output;
}

/// The first frame of the model at the same place: an output with `at` has one of its own, NAME.output.
ModelPlace place_of_frame(const spec::Model& m, int frame) {
  const auto at = [&](int k) -> const spec::Frame& { return m.frames[static_cast<std::size_t>(k)]; };
  const auto same = [&](const spec::Frame& f) {
    return f.body == at(frame).body && f.flexible_frame == at(frame).flexible_frame &&
           f.node == at(frame).node && f.pose.position == at(frame).pose.position &&
           f.pose.rotation == at(frame).pose.rotation;
  };
  const auto first = std::find_if(m.frames.begin(), m.frames.end(), same);
  ModelPlace out = place_in(m.frames, static_cast<int>(first - m.frames.begin()), "frame");
  const auto is_called = [](const auto& list, const std::string& name) {
    return std::any_of(list.begin(), list.end(), [&](const auto& one) { return one.name == name; });
  };
  const std::string end = ".output";
  if (!first->name.ends_with(end)) return out;
  const std::string output = first->name.substr(0, first->name.size() - end.size()), point = point_of(output);
  if (!is_called(m.outputs, output) || is_called(m.frames, point)) return out;
  return {"frame." + point, "frame", fmt::format("point '{}'", point)};
}

ModelPlace place_of(const spec::Model& m, const OutputInfo& info, const spec::Output& o) {
  switch (info.of) {
    case OutputInfo::Of::frame:
      return place_of_frame(m, o.item);
    case OutputInfo::Of::joint:
      return place_in(m.joints, o.item, "joint");
    case OutputInfo::Of::body:
      return place_in(m.bodies, o.item, "body");
    case OutputInfo::Of::bodies:
      if (o.bodies.empty()) return {"mechanism", "mechanism", "the mechanism"};
      return o.bodies.size() == 1 ? place_in(m.bodies, o.bodies[0], "body") : ModelPlace{};
    case OutputInfo::Of::spring:
      return place_in(m.springs, o.item, "spring");
    case OutputInfo::Of::tyre:
      return place_in(m.tyres, o.item, "tyre");
    case OutputInfo::Of::contact:
      return place_in(m.contacts, o.item, "contact");
    case OutputInfo::Of::element:
      return place_in(m.elements, o.item, "element");
    default:
      return {};
  }
}

/// The kind without what its place states already: "velocity" of joint_velocity.
std::string quantity_of(const OutputInfo& info, const std::string& place) {
  const std::string name(info.name), before = place + "_";
  if (name == "joint") return "position";
  return name.starts_with(before) ? name.substr(before.size()) : name;
}

bool has(OutputInfo::Words words, const std::string& word) {
  return std::any_of(words.begin(), words.end(), [&](const char* w) { return word == w; });
}

/// Whether a word names a component of a vector: x, y and z behind the same letters are all there, or w, x, y
/// and z of a quaternion.
void find_component(const OutputInfo& info, int component, OutputMeaning& to) {
  const std::string word = info.words[static_cast<std::size_t>(component)];
  if (info.words.size() == 4 && has(info.words, "w")) {
    to.component = word;
    to.number = component;
    to.components = 4;
    return;
  }
  const std::string front = word.substr(0, word.size() - 1);
  const std::size_t axis = std::string("xyz").find(word.back());
  if (axis == std::string::npos) return;
  for (const char* letter : axis_words)
    if (!has(info.words, front + letter)) return;
  if (front == "m") to.quantity = "moment";
  to.component = axis_words[axis];
  to.number = static_cast<int>(axis);
  to.components = 3;
}

OutputMeaning place_of_output(const spec::Model& m, const spec::Output& o) {
  const OutputInfo& info = output_info(o);
  OutputMeaning out;
  out.of = place_of(m, info, o);
  // Of these there may be several, which differ in more than a component.
  if (info.place != OutputInfo::Place::none || info.along || info.reference || info.modes || o.about) {
    out.quantity = o.name;
    return out;
  }
  out.quantity = quantity_of(info, out.of.kind);
  if (!info.words.empty()) find_component(info, o.component, out);
  if (o.own_axes) out.quantity += ".own_axes";
  if (out.components > 0) return out;
  if (!info.words.empty())
    out.quantity += "." + std::string(info.words[static_cast<std::size_t>(o.component)]);
  if (info.count && info.count(joint_info(m.joints[static_cast<std::size_t>(o.item)].type)) > 1)
    out.quantity += fmt::format(".{}", o.component);
  return out;
}

/// Of a model without outputs: a joint's coordinate, joint.NAME.position or joint.NAME.position.1.
OutputMeaning place_of_coordinate(const spec::Model& m, const std::string& name) {
  for (std::size_t k = 0; k < m.joints.size(); ++k) {
    const std::string front = fmt::format("joint.{}.", m.joints[k].name);
    if (!name.starts_with(front + "position")) continue;
    OutputMeaning out;
    out.of = place_in(m.joints, static_cast<int>(k), "joint");
    out.quantity = name.substr(front.size());
    return out;
  }
  return {};
}

std::string vector_meaning(std::string quantity, const ModelPlace& of) {
  const std::string own = ".own_axes";
  const bool own_axes = quantity.ends_with(own);
  if (own_axes) quantity.resize(quantity.size() - own.size());
  std::replace(quantity.begin(), quantity.end(), '_', ' ');
  return fmt::format("{} of {}{}", quantity, of.meaning, own_axes ? " in its own axes" : "");
}

/// Follows values back to inputs.
class InputSearch {
 public:
  using Source = spec::Source;
  explicit InputSearch(const spec::Model& m)
      : m_(m), seen_by_(m.inputs.size()), places_(m.inputs.size()), signals_(m.signals.size()) {}

  void act(const std::vector<Source>& sources, const ModelPlace& place) {
    std::fill(signals_.begin(), signals_.end(), false);
    for (const Source& s : sources) follow(s, place);
  }
  void act_by_signal(int signal, const ModelPlace& place) {
    if (signal >= 0) act({{Source::Kind::signal, signal}}, place);
  }
  std::vector<ModelPlace> places() {
    for (std::size_t k = 0; k < places_.size(); ++k)
      if (seen_by_[k] != 1) places_[k] = {};
    return std::move(places_);
  }

 private:
  void follow(const Source& s, const ModelPlace& place) {
    const std::size_t at = static_cast<std::size_t>(std::max(s.index, 0));
    if (s.kind == Source::Kind::input) {
      if (places_[at].name != place.name || seen_by_[at] == 0) ++seen_by_[at];
      places_[at] = place;
    }
    if (s.kind != Source::Kind::signal || signals_[at]) return;
    signals_[at] = true;
    const spec::Signal& signal = m_.signals[at];
    for (const Source& next : signal.law.arguments) follow(next, place);
    if (signal.block < 0) return;
    for (const spec::Law& law : m_.blocks[static_cast<std::size_t>(signal.block)].inputs)
      for (const Source& next : law.arguments) follow(next, place);
  }

  const spec::Model& m_;
  std::vector<int> seen_by_;  ///< by how many places
  std::vector<ModelPlace> places_;
  std::vector<bool> signals_;  ///< that were followed for the place of now
};

}  // namespace

std::vector<OutputMeaning> output_places(const GeneratedCode& code, const spec::Model& model) {
  std::vector<OutputMeaning> out;
  for (const GeneratedVariable& v : code.outputs) {
    const auto output = std::find_if(model.outputs.begin(), model.outputs.end(),
                                     [&](const spec::Output& o) { return o.name == v.name; });
    out.push_back(output != model.outputs.end() ? place_of_output(model, *output)
                  : model.outputs.empty()       ? place_of_coordinate(model, v.name)
                                                : OutputMeaning{});
  }
  return out;
}

std::vector<OutputVector> output_vectors(const GeneratedCode& code,
                                         const std::vector<OutputMeaning>& places) {
  // By their names, too: the same vector may be an output twice.
  std::map<std::tuple<std::string, std::string, std::string>, std::vector<int>> found;
  for (std::size_t k = 0; k < places.size(); ++k) {
    const OutputMeaning& p = places[k];
    if (p.components == 0 || p.of.name.empty()) continue;
    std::vector<int>& outputs = found[{p.of.name, p.quantity, stem_of(code.outputs[k].name)}];
    outputs.resize(static_cast<std::size_t>(p.components), -1);
    outputs[static_cast<std::size_t>(p.number)] = static_cast<int>(k);
  }
  std::vector<OutputVector> out;
  for (const auto& [key, outputs] : found) {
    if (std::find(outputs.begin(), outputs.end(), -1) != outputs.end()) continue;
    const ModelPlace& of = places[static_cast<std::size_t>(outputs[0])].of;
    const auto& [place, quantity, stem] = key;
    out.push_back({of, quantity, outputs, stem, vector_meaning(quantity, of)});
  }
  std::sort(out.begin(), out.end(), [](const OutputVector& a, const OutputVector& b) {
    return *std::min_element(a.outputs.begin(), a.outputs.end()) <
           *std::min_element(b.outputs.begin(), b.outputs.end());
  });
  return out;
}

std::vector<ModelPlace> input_places(const spec::Model& model) {
  InputSearch search(model);
  const auto joint = [&](int k) { return place_in(model.joints, k, "joint"); };
  for (std::size_t k = 0; k < model.joints.size(); ++k) {
    for (const spec::Drive& d : model.joints[k].drives)
      search.act_by_signal(d.signal, joint(static_cast<int>(k)));
    for (const spec::JointSpring& s : model.joints[k].springs)
      search.act(s.general.arguments, joint(static_cast<int>(k)));
  }
  for (std::size_t k = 0; k < model.elements.size(); ++k) {
    const spec::Element& e = model.elements[k];
    const ModelPlace place = e.on == spec::Element::On::coordinate
                                 ? joint(e.joint)
                                 : place_in(model.elements, static_cast<int>(k), "element");
    search.act(e.arguments, place);
    search.act(e.general.arguments, place);
  }
  for (std::size_t k = 0; k < model.springs.size(); ++k)
    search.act(model.springs[k].general.arguments, place_in(model.springs, static_cast<int>(k), "spring"));
  for (const spec::Load& l : model.loads) search.act_by_signal(l.signal, place_of_frame(model, l.frame));
  for (std::size_t k = 0; k < model.roads.size(); ++k)
    search.act_by_signal(model.roads[k].signal, place_in(model.roads, static_cast<int>(k), "road"));
  return search.places();
}

}  // namespace mimbre::portable
