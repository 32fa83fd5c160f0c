#include "portable/fmu/terminals.h"

#include <algorithm>
#include <set>

#include "portable/fmu/output_places.h"

namespace mimbre::portable {
namespace {

using Role = FmuVariable::Role;

class Terminals {
 public:
  Terminals(const FmuCode& fmu, const spec::Model& model)
      : fmu_(fmu),
        outputs_(output_places(fmu.code, model)),
        vectors_(output_vectors(fmu.code, outputs_)),
        inputs_(input_places(model)) {}

  std::vector<Terminal> find() {
    std::size_t input = 0;
    for (const FmuVariable& v : fmu_.variables) {
      if (v.role == Role::input) add_input(v, inputs_[input]);
      if (v.role == Role::input || v.role == Role::parameter) ++input;
      if (v.role == Role::output) add_output(v);
    }
    return std::move(list_);
  }

 private:
  Terminal& terminal_of(const ModelPlace& place) {
    const auto known =
        std::find_if(list_.begin(), list_.end(), [&](const Terminal& t) { return t.name == place.name; });
    if (known != list_.end()) return *known;
    list_.push_back({place.name, "bus", "_mimbre_" + place.kind, place.meaning});
    return list_.back();
  }
  static bool is_free(const Terminal& t, const std::string& name) {
    return std::none_of(t.members.begin(), t.members.end(), [&](const auto& m) { return m.first == name; }) &&
           std::none_of(t.inner.begin(), t.inner.end(), [&](const Terminal& i) { return i.name == name; });
  }
  /// A member, or where there is one of that name by the name of the variable.
  static void add(Terminal& t, const std::string& name, const std::string& variable) {
    for (std::string one : {name, variable})
      if (is_free(t, one)) {
        t.members.emplace_back(std::move(one), variable);
        return;
      }
  }

  void add_input(const FmuVariable& v, const ModelPlace& place) {
    if (place.name.empty()) return;
    Terminal& t = terminal_of(place);
    add(t, v.name, v.name);
    t.takes = true;
  }
  void add_output(const FmuVariable& v) {
    const OutputMeaning& p = outputs_[static_cast<std::size_t>(v.outputs[0])];
    if (p.of.name.empty()) return;
    Terminal& t = terminal_of(p.of);
    if (p.components == 0) return add(t, p.quantity, v.name);
    const auto vector = std::find_if(vectors_.begin(), vectors_.end(), [&](const OutputVector& one) {
      return std::find(one.outputs.begin(), one.outputs.end(), v.outputs[0]) != one.outputs.end();
    });
    if (v.outputs.size() > 1) return add(t, p.quantity, v.name);
    if (vector == vectors_.end()) return add(t, p.quantity + "." + p.component, v.name);
    if (added_.insert(&*vector).second) add_vector(t, *vector);
  }
  void add_vector(Terminal& t, const OutputVector& vector) {
    const std::string name = is_free(t, vector.quantity) ? vector.quantity : vector.stem;
    if (!is_free(t, name)) return;
    Terminal inner{name, "plug", "_mimbre_vector", vector.meaning};
    for (const int output : vector.outputs)
      inner.members.emplace_back(outputs_[static_cast<std::size_t>(output)].component, name_of(output));
    t.inner.push_back(std::move(inner));
  }
  const std::string& name_of(int output) const {
    const auto found = std::find_if(fmu_.variables.begin(), fmu_.variables.end(), [&](const FmuVariable& v) {
      return v.role == Role::output && v.outputs.size() == 1 && v.outputs[0] == output;
    });
    return found->name;
  }

  const FmuCode& fmu_;
  const std::vector<OutputMeaning> outputs_;
  const std::vector<OutputVector> vectors_;
  const std::vector<ModelPlace> inputs_;
  std::set<const OutputVector*> added_;
  std::vector<Terminal> list_;
};

}  // namespace

std::vector<Terminal> fmu_terminals(const FmuCode& fmu, const spec::Model& model) {
  return Terminals(fmu, model).find();
}

}  // namespace mimbre::portable
