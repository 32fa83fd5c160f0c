#include "portable/library/runtime.h"

#include <algorithm>
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
#include <tuple>

#include "base/hash64.h"
#include "mimbre/model_bytes.h"
#include "mimbre/simulation.h"
#include "portable/library/runtime_options.h"

using namespace mimbre;

namespace {

/// Instances of one FMU share its model, which is compiled once.
std::shared_ptr<const Model> shared_model(std::span<const std::byte> bytes) {
  static std::mutex mutex;
  static std::map<std::tuple<const std::byte*, std::size_t, std::uint64_t>, std::weak_ptr<const Model>> known;
  Hash64 hash;
  hash.add(std::string_view(reinterpret_cast<const char*>(bytes.data()), bytes.size()));
  const std::lock_guard lock(mutex);
  std::erase_if(known, [](const auto& one) { return one.second.expired(); });
  std::weak_ptr<const Model>& entry = known[{bytes.data(), bytes.size(), hash.value()}];
  std::shared_ptr<const Model> model = entry.lock();
  if (!model) entry = model = Model::compile(model_from_bytes(bytes));
  return model;
}

}  // namespace

struct mimbre_model {
  explicit mimbre_model(std::shared_ptr<const Model> given) : model(std::move(given)) { begin(); }

  void begin() {
    if (!begun && !stale && inputs.empty() && simulation) return;
    inputs.clear();
    make();
    begun = stale = false;
  }
  /// A start with inputs that were set. Keeps the older one where there is none.
  bool refresh() {
    if (!stale) return true;
    try {
      make();
    } catch (const std::exception& error) {
      message = error.what();
      return false;
    }
    stale = false;
    return true;
  }
  void make() {
    RunOptions options = portable::runtime_options();
    options.inputs = inputs;
    simulation = std::make_unique<Simulation>(model, options);
  }

  std::shared_ptr<const Model> model;
  std::unique_ptr<Simulation> simulation;
  std::map<std::string, double> inputs;  ///< that were set before
  bool begun = false;                    ///< inputs do not move the start any more
  bool stale = false;                    ///< the start is not yet that of the inputs
  std::string message;
  Simulation::Snapshot snapshot;
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

mimbre_model* mimbre_model_open(const unsigned char* bytes, size_t size, char* message, size_t room) {
  std::string why;
  try {
    return new mimbre_model(shared_model({reinterpret_cast<const std::byte*>(bytes), size}));
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

int mimbre_model_find(mimbre_model* m) {
  return guarded(m, [&] { return m->refresh() ? mimbre_model_ok : mimbre_model_failed; });
}

int mimbre_model_start(mimbre_model* m) {
  const int status = mimbre_model_find(m);
  m->begun = m->begun || status == mimbre_model_ok;
  return status;
}

double mimbre_model_time(const mimbre_model* m) { return m->simulation->time(); }

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
    if (m->refresh()) value = m->simulation->value(Simulation::Channel{output});
    return mimbre_model_ok;
  });
  return value;
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

int mimbre_model_save(mimbre_model* m, unsigned char* bytes, size_t size) {
  return guarded(m, [&] {
    if (!m->refresh()) return mimbre_model_failed;
    m->simulation->save(m->snapshot);
    const std::vector<std::byte> state = m->snapshot.bytes();
    const portable::StateHead head{state.size(), m->begun ? 1u : 0u};
    if (sizeof head + state.size() > size) throw std::runtime_error("the state has outgrown its place");
    std::memset(bytes, 0, size);
    std::memcpy(bytes, &head, sizeof head);
    std::memcpy(bytes + sizeof head, state.data(), state.size());
    return mimbre_model_ok;
  });
}

int mimbre_model_restore(mimbre_model* m, const unsigned char* bytes, size_t size) {
  return guarded(m, [&] {
    portable::StateHead head;
    if (size < sizeof head) throw std::runtime_error("the state is too short");
    std::memcpy(&head, bytes, sizeof head);
    if (head.size > size - sizeof head) throw std::runtime_error("the state is damaged");
    m->simulation->restore(Simulation::Snapshot::from_bytes(
        {reinterpret_cast<const std::byte*>(bytes) + sizeof head, static_cast<std::size_t>(head.size)}));
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
