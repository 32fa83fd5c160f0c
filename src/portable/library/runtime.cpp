#include "portable/library/runtime.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>
#include <map>
#include <memory>
#include <mutex>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "analysis/held_variations.h"
#include "base/hash64.h"
#include "mimbre/model_bytes.h"
#include "mimbre/simulation.h"
#include "portable/library/model_source.h"
#include "portable/library/runtime_options.h"
#include "simulation/observe/channels.h"
#include "spec/model_members.h"

using namespace mimbre;

namespace {

/// A compiled model, with what it has of fixed parameters. Instances of one FMU share it.
struct Variant {
  std::shared_ptr<const Model> model;
  std::vector<model_file::DeclaredParameter> parameters;
  spec::Simulation simulation;  ///< as it is read
  std::vector<int> channels;    ///< by the number of an output's channel in the model without parameters
};

/// Parameters that were set, by number.
using Chosen = std::map<int, double>;

/// An FMU's bytes, by which its instances know what they share.
struct Source {
  std::span<const std::byte> model, source;

  std::string key(const Chosen& chosen) const {
    std::string key;
    for (const auto& bytes : {model, source}) {
      Hash64 hash;
      hash.add(std::string_view(reinterpret_cast<const char*>(bytes.data()), bytes.size()));
      key += fmt::format("{} {} {}\n", static_cast<const void*>(bytes.data()), bytes.size(), hash.value());
    }
    for (const auto& [number, value] : chosen)
      key += fmt::format("{} {}\n", number, std::bit_cast<std::uint64_t>(value));
    return key;
  }
};

/// What all of a key share as long as one has it, made by `make` for the first.
template <class T, class Make>
std::shared_ptr<const T> shared_by(const std::string& key, const Make& make) {
  static std::mutex mutex;
  static std::map<std::string, std::weak_ptr<const T>> known;
  const std::lock_guard lock(mutex);
  std::erase_if(known, [](const auto& one) { return one.second.expired(); });
  std::weak_ptr<const T>& entry = known[key];
  std::shared_ptr<const T> value = entry.lock();
  if (!value) entry = value = make();
  return value;
}

std::shared_ptr<const Variant> first_variant(const Source& of) {
  return shared_by<Variant>(of.key({}), [&] {
    auto out = std::make_shared<Variant>();
    out->model = Model::compile(model_from_bytes(of.model));
    const Channels channels(out->model->compiled());
    for (std::size_t k = 0; k < channels.info().size(); ++k) out->channels.push_back(static_cast<int>(k));
    if (of.source.empty()) return out;
    portable::ModelSource source = portable::source_from_bytes(of.source);
    out->parameters = std::move(source.parameters);
    out->simulation = source.simulation;
    return out;
  });
}

/// All of the method, as bytes.
std::vector<std::byte> method_bytes(spec::Simulation simulation) {
  simulation.end = simulation.output_interval = 0;
  simulation.end_given = simulation.start_at_equilibrium = false;
  archive::Writer to;
  to(simulation);
  return to.take();
}

/// Inputs start as in the model without parameters, and the method is that one's.
void take_over(const Variant& of, spec::Model& model) {
  const spec::Model& first = of.model->spec();
  if (method_bytes(model.simulation) != method_bytes(of.simulation))
    throw InputError(Mark{},
                     "the section 'simulation' has another step or method, which is fixed in an FMU: "
                     "write one with these parameters");
  const bool at_equilibrium = model.simulation.start_at_equilibrium;
  model.simulation = first.simulation;
  model.simulation.start_at_equilibrium = at_equilibrium;
  const auto names_of = [](const spec::Model& m) {
    std::vector<std::string> names;
    for (const spec::Input& input : m.inputs) names.push_back(input.name);
    return names;
  };
  if (names_of(first) != names_of(model))
    throw InputError(Mark{}, "the model has other inputs than the FMU: no parameter may change these");
  for (std::size_t k = 0; k < model.inputs.size(); ++k)
    model.inputs[k].start = std::clamp(first.inputs[k].start, model.inputs[k].min, model.inputs[k].max);
}

/// Where the channels of the first one's outputs are in the other one.
std::vector<int> places_of_channels(const Compiled& first, const Compiled& other) {
  const Channels from(first), to(other);
  std::map<std::string, int> places;
  for (std::size_t k = 0; k < to.info().size(); ++k) places.emplace(to.info()[k].name, static_cast<int>(k));
  std::vector<int> out(from.info().size(), -1);
  for (const auto& [channel, name] : portable::output_channels(from.info(), from.output_count())) {
    const auto found = places.find(from.info()[static_cast<std::size_t>(channel)].name);
    if (found == places.end())
      throw InputError(Mark{}, fmt::format("the model has no output '{}', which the FMU has", name));
    out[static_cast<std::size_t>(channel)] = found->second;
  }
  return out;
}

std::shared_ptr<const Variant> variant_of(const Source& of, const std::shared_ptr<const Variant>& first,
                                          const Chosen& chosen) {
  if (chosen.empty()) return first;
  std::map<std::string, double> values;
  std::string words;
  for (const auto& [number, value] : chosen) {
    const std::string& name = first->parameters.at(static_cast<std::size_t>(number)).name;
    values[name] = value;
    words += fmt::format("{}{} = {}", words.empty() ? "with " : ", ", name, value);
  }
  try {
    return shared_by<Variant>(of.key(chosen), [&] {
      portable::ModelRead read = portable::read_model(portable::source_from_bytes(of.source), values);
      take_over(*first, read.model);
      auto out = std::make_shared<Variant>();
      out->model = Model::compile(std::move(read.model));
      out->parameters = std::move(read.parameters);
      out->channels = places_of_channels(first->model->compiled(), out->model->compiled());
      if (out->parameters.size() != first->parameters.size())
        throw InputError(Mark{}, "the model has other parameters than the FMU");
      return out;
    });
  } catch (const std::exception& error) {
    throw std::runtime_error(fmt::format("{}: {}", words, error.what()));
  }
}

std::unique_ptr<Simulation> simulation_of(const Variant& variant,
                                          const std::map<std::string, double>& inputs) {
  RunOptions options = portable::runtime_options();
  options.inputs = inputs;
  return std::make_unique<Simulation>(variant.model, options);
}

}  // namespace

struct mimbre_model {
  explicit mimbre_model(const Source& of) : source(of), first(first_variant(of)), variant(first) { begin(); }

  void begin() {
    if (!begun && !stale && inputs.empty() && chosen.empty() && simulation) return;
    inputs.clear();
    chosen.clear();
    take(first, simulation_of(*first, {}));
    begun = false;
  }
  void take(std::shared_ptr<const Variant> of, std::unique_ptr<Simulation> moved) {
    variations.reset();
    variant = std::move(of);
    simulation = std::move(moved);
    stale = outdated = false;
  }
  /// The parameters in force.
  const std::vector<model_file::DeclaredParameter>& parameters() {
    if (outdated) {
      known = variant_of(source, first, chosen);
      return known->parameters;
    }
    return variant->parameters;
  }
  /// A start with inputs and parameters that were set. Keeps the older one where there is none.
  bool refresh() {
    if (!stale) return true;
    try {
      const auto of = variant_of(source, first, chosen);
      take(of, simulation_of(*of, inputs));
    } catch (const std::exception& error) {
      message = error.what();
      return false;
    }
    return true;
  }
  int channel(int output) const { return variant->channels.at(static_cast<std::size_t>(output)); }

  const Source source;
  const std::shared_ptr<const Variant> first;  ///< without parameters
  std::shared_ptr<const Variant> variant, known;
  std::unique_ptr<Simulation> simulation;
  std::map<std::string, double> inputs;  ///< that were set before
  Chosen chosen;
  bool begun = false;     ///< inputs do not move the start any more
  bool stale = false;     ///< the start is not yet that of the inputs and parameters
  bool outdated = false;  ///< the variant is not yet that of the parameters
  std::string message;
  Simulation::Snapshot snapshot;
  std::unique_ptr<HeldVariations> variations;  ///< made when first asked for
};

namespace {

/// Runs what may throw.
template <class Call>
int guarded(mimbre_model* m, const Call& call) {
  try {
    return call();
  } catch (const std::exception& error) {
    m->message = error.what();
  } catch (...) {
    m->message = "an error of unknown kind";
  }
  return mimbre_model_failed;
}

}  // namespace

mimbre_model* mimbre_model_open(const unsigned char* bytes, size_t size, const unsigned char* source,
                                size_t source_size, char* message, size_t room) {
  std::string why;
  try {
    return new mimbre_model(Source{{reinterpret_cast<const std::byte*>(bytes), size},
                                   {reinterpret_cast<const std::byte*>(source), source_size}});
  } catch (const std::exception& error) {
    why = error.what();
  } catch (...) {
    why = "an error of unknown kind";
  }
  if (room > 0) {
    const std::size_t length = std::min(why.size(), room - 1);
    std::memcpy(message, why.data(), length);
    message[length] = 0;
  }
  return nullptr;
}

void mimbre_model_close(mimbre_model* model) { delete model; }

int mimbre_model_begin(mimbre_model* m) {
  return guarded(m, [&] {
    m->begin();
    return mimbre_model_ok;
  });
}

int mimbre_model_check_parameter(mimbre_model* m, int parameter, double value) {
  return guarded(m, [&] {
    const model_file::DeclaredParameter& p = m->first->parameters.at(static_cast<std::size_t>(parameter));
    if (p.derived)
      m->message = fmt::format("parameter '{}' follows from others in the model file: set those", p.name);
    else if (m->begun)
      m->message =
          fmt::format("parameter '{}' is fixed: it can be set only before the end of initialization", p.name);
    else if (!(value >= p.min && value <= p.max) || !std::isfinite(value) ||
             (p.integer && value != std::floor(value)))
      m->message = fmt::format("parameter '{}' set to {}: {} is needed", p.name, value,
                               model_file::range_text(p.min, p.max, p.integer));
    else
      return mimbre_model_ok;
    m->message += "; nothing was set";
    return mimbre_model_failed;
  });
}

int mimbre_model_set_parameter(mimbre_model* m, int parameter, double value) {
  return guarded(m, [&] {
    const double before =
        std::get<double>(m->first->parameters.at(static_cast<std::size_t>(parameter)).value);
    const auto at = m->chosen.find(parameter);
    if (value == (at == m->chosen.end() ? before : at->second)) return mimbre_model_ok;
    if (value == before)
      m->chosen.erase(at);
    else
      m->chosen.insert_or_assign(parameter, value);
    m->stale = m->outdated = true;
    return mimbre_model_ok;
  });
}

int mimbre_model_parameter(mimbre_model* m, int parameter, double* value) {
  return guarded(m, [&] {
    const model_file::DeclaredParameter& p = m->first->parameters.at(static_cast<std::size_t>(parameter));
    const auto at = m->chosen.find(parameter);
    if (at != m->chosen.end())
      *value = at->second;
    else if (!p.derived)
      *value = std::get<double>(p.value);
    else
      *value = std::get<double>(m->parameters().at(static_cast<std::size_t>(parameter)).value);
    return mimbre_model_ok;
  });
}

int mimbre_model_find(mimbre_model* m) {
  return guarded(m, [&] { return m->refresh() ? mimbre_model_ok : mimbre_model_failed; });
}

int mimbre_model_start(mimbre_model* m) {
  const int status = mimbre_model_find(m);
  m->begun = m->begun || status == mimbre_model_ok;
  return status;
}

double mimbre_model_time(const mimbre_model* m) { return m->simulation->time(); }

double mimbre_model_event_count(const mimbre_model* m) {
  double count = 0;
  for (const EventRecord& event : m->simulation->events()) count += static_cast<double>(event.count);
  return count;
}

int mimbre_model_set_input(mimbre_model* m, int input, double value) {
  return guarded(m, [&] {
    const std::vector<spec::Input>& inputs = m->simulation->inputs();
    if (m->begun) {
      m->simulation->set_input(input, value);
    } else {
      m->inputs.insert_or_assign(inputs.at(static_cast<std::size_t>(input)).name, value);
      m->stale = m->stale || m->simulation->input_value(input) != value;
    }
    return mimbre_model_ok;
  });
}

double mimbre_model_output(mimbre_model* m, int output) {
  double value = std::numeric_limits<double>::quiet_NaN();
  guarded(m, [&] {
    if (m->refresh()) value = m->simulation->value(Simulation::Channel{m->channel(output)});
    return mimbre_model_ok;
  });
  return value;
}

int mimbre_model_vary(mimbre_model* m, const double* inputs, double time, const int* outputs, int count,
                      double* derivatives) {
  return guarded(m, [&] {
    if (!m->refresh()) return mimbre_model_failed;
    if (!m->variations) {
      const Redundancy found = m->simulation->redundancy();
      m->variations = std::make_unique<HeldVariations>(m->variant->model, m->simulation->method(),
                                                       found.equations + found.nearly > 0);
    }
    std::vector<int> channels;
    for (int k = 0; k < count; ++k) channels.push_back(m->channel(outputs[k]));
    m->simulation->save(m->snapshot);
    m->variations->along(m->snapshot, {inputs, m->simulation->inputs().size()}, time, channels, derivatives);
    return mimbre_model_ok;
  });
}

int mimbre_model_step(mimbre_model* m, int* iterations) {
  *iterations = 0;
  return guarded(m, [&] {
    if (!m->refresh()) return mimbre_model_failed;
    m->begun = true;
    const StepReport report = m->simulation->step();
    *iterations = report.iterations;
    if (!report.ok()) {
      m->message = m->simulation->explain(report);
      return mimbre_model_failed;
    }
    if (m->simulation->stopped()) {
      m->message = "an event of the model ends the run";
      for (const EventRecord& event : m->simulation->events())
        if (event.stops && event.last == m->simulation->time())
          m->message = "the event '" + event.name + "' of the model ends the run";
      return mimbre_model_stopped;
    }
    return report.unconverged ? mimbre_model_unconverged : mimbre_model_ok;
  });
}

const char* mimbre_model_message(const mimbre_model* m) { return m->message.c_str(); }

size_t mimbre_model_state_size(mimbre_model* m) {
  std::size_t size = 0;
  guarded(m, [&] {
    if (m->refresh())
      size = portable::state_bytes(*m->simulation) + m->chosen.size() * sizeof(portable::StateParameter);
    return mimbre_model_ok;
  });
  return size;
}

int mimbre_model_save(mimbre_model* m, unsigned char* bytes, size_t size) {
  return guarded(m, [&] {
    if (!m->refresh()) return mimbre_model_failed;
    m->simulation->save(m->snapshot);
    const std::vector<std::byte> state = m->snapshot.bytes();
    const portable::StateHead head{m->chosen.size(), state.size(), m->begun ? 1u : 0u};
    if (sizeof head + head.parameters * sizeof(portable::StateParameter) + state.size() > size)
      throw std::runtime_error("the state has outgrown its place");
    const auto put = [&](const void* from, std::size_t count) {
      std::memcpy(bytes, from, count);
      bytes += count;
    };
    put(&head, sizeof head);
    for (const auto& [number, value] : m->chosen) {
      const portable::StateParameter parameter{static_cast<std::uint64_t>(number), value};
      put(&parameter, sizeof parameter);
    }
    put(state.data(), state.size());
    return mimbre_model_ok;
  });
}

namespace {

/// Inputs and tunable parameters as a snapshot has them.
std::map<std::string, double> inputs_of(const Variant& variant, const Simulation::Snapshot& snapshot) {
  std::map<std::string, double> out;
  const Compiled& m = variant.model->compiled();
  for (const SignalsData::HeldInput& h : m.signals.held) {
    if (h.input < 0) continue;
    if (h.held >= snapshot.u.size()) throw std::runtime_error("the state is damaged");
    out[m.spec().inputs[static_cast<std::size_t>(h.input)].name] = snapshot.u[h.held];
  }
  return out;
}

}  // namespace

int mimbre_model_restore(mimbre_model* m, const unsigned char* bytes, size_t size) {
  return guarded(m, [&] {
    portable::StateHead head;
    if (size < sizeof head) throw std::runtime_error("the state is too short");
    std::memcpy(&head, bytes, sizeof head);
    std::size_t left = size - sizeof head, at = sizeof head;
    if (head.parameters > left / sizeof(portable::StateParameter))
      throw std::runtime_error("the state is damaged");
    Chosen chosen;
    for (std::uint64_t k = 0; k < head.parameters; ++k, at += sizeof(portable::StateParameter)) {
      portable::StateParameter parameter;
      std::memcpy(&parameter, bytes + at, sizeof parameter);
      if (parameter.number >= m->first->parameters.size()) throw std::runtime_error("the state is damaged");
      chosen[static_cast<int>(parameter.number)] = parameter.value;
    }
    left = size - at;
    if (head.size > left) throw std::runtime_error("the state is damaged");
    const auto snapshot = Simulation::Snapshot::from_bytes(
        {reinterpret_cast<const std::byte*>(bytes) + at, static_cast<std::size_t>(head.size)});
    if (chosen == m->chosen && !m->outdated) {
      m->simulation->restore(snapshot);
    } else {
      const auto of = variant_of(m->source, m->first, chosen);
      auto simulation = simulation_of(*of, inputs_of(*of, snapshot));
      simulation->restore(snapshot);
      m->take(of, std::move(simulation));
      m->chosen = std::move(chosen);
    }
    m->begun = head.begun != 0;
    m->stale = false;
    if (!m->begun) {
      const std::vector<spec::Input>& inputs = m->simulation->inputs();
      for (std::size_t k = 0; k < inputs.size(); ++k)
        m->inputs.insert_or_assign(inputs[k].name, m->simulation->input_value(static_cast<int>(k)));
    }
    return mimbre_model_ok;
  });
}
