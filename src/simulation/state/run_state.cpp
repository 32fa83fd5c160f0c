#include "mimbre/run_state.h"

#include <fmt/format.h>

#include <cstring>
#include <fstream>
#include <iterator>
#include <span>
#include <stdexcept>
#include <string_view>

#include "base/hash64.h"
#include "base/output_place.h"
#include "mimbre/build.h"
#include "mimbre/diagnostics.h"

namespace mimbre {
namespace {

/// Ends with the number of the layout.
constexpr std::string_view run_state_mark = "mimbre-run-state-004";
constexpr std::string_view run_state_kind = run_state_mark.substr(0, 17);

void add_matrix(Hash64& hash, const double* x, Eigen::Index count) {
  for (Eigen::Index k = 0; k < count; ++k) hash.add(x[k]);
}

std::uint64_t hash_of(std::string_view bytes) {
  Hash64 hash;
  hash.add(bytes);
  return hash.value();
}

/// Puts values behind each other, or takes them back: the same list serves both.
class Writer {
 public:
  std::string bytes;
  void operator()(const std::string& text) {
    (*this)(static_cast<std::int64_t>(text.size()));
    bytes += text;
  }
  template <class Number>
  void operator()(const Number& number) {
    bytes.append(reinterpret_cast<const char*>(&number), sizeof number);
  }
};

class Reader {
 public:
  explicit Reader(std::string_view bytes) : bytes_(bytes) {}
  bool good() const { return good_; }
  void operator()(std::string& text) {
    std::int64_t size = 0;
    (*this)(size);
    text = take(size);
  }
  template <class Number>
  void operator()(Number& number) {
    if (const std::string_view from = take(sizeof number); good_)
      std::memcpy(&number, from.data(), sizeof number);
  }

 private:
  std::string_view take(std::int64_t size) {
    good_ = good_ && size >= 0 && static_cast<std::uint64_t>(size) <= bytes_.size();
    if (!good_) return {};
    const std::string_view taken = bytes_.substr(0, static_cast<std::size_t>(size));
    bytes_.remove_prefix(taken.size());
    return taken;
  }
  std::string_view bytes_;
  bool good_ = true;
};

template <class State, class Each>
void for_values(State& s, Each&& each) {
  auto& t = s.totals;
  each(t.steps);
  each(t.iterations);
  each(t.factorisations);
  each(t.repeated_steps);
  each(t.unconverged_steps);
  each(t.cpu_seconds);
  each(t.violations.position_violation);
  each(t.violations.angle_violation);
  each(t.violations.velocity_violation);
  each(t.violations.angular_velocity_violation);
  each(s.rows.count);
  each(s.rows.hash);
  each(s.recorded);
  for (auto* text : {&s.options_json, &s.program, &s.results, &s.csv}) each(*text);
}

}  // namespace

void RecordedRows::add(const ResultsRow& row) {
  Hash64 digest;
  digest.add(std::string_view(reinterpret_cast<const char*>(&hash), sizeof hash));
  digest.add(row.time);
  add_matrix(digest, row.channels.data(), row.channels.size());
  add_matrix(digest, row.poses.data(), row.poses.size());
  add_matrix(digest, row.modes.data(), row.modes.size());
  hash = digest.value();
  ++count;
}

std::string this_program() {
  const BuildInfo& build = build_info();
  return fmt::format("mimbre {}, {}, {}", build.version, build.compiler, build.instructions);
}

void write_run_state(const std::string& path, const RunState& state) {
  Writer out;
  out.bytes = run_state_mark;
  for_values(state, out);
  const std::vector<std::byte> snapshot = state.snapshot.bytes();
  out(std::string(reinterpret_cast<const char*>(snapshot.data()), snapshot.size()));
  out(hash_of(out.bytes));
  try {
    write_whole(path, out.bytes);
    remove_abandoned_parts(path, [](const std::string&) { return true; });  // half a state is of no use
  } catch (const std::runtime_error& error) {
    throw std::runtime_error(fmt::format("cannot write the state to '{}': {}", path, error.what()));
  }
}

RunState read_run_state(const std::string& path) {
  const auto refuse = [&](const std::string& why) { return InputError(Mark{path, 0, 0}, why); };
  std::ifstream file(path, std::ios::binary);
  if (!file) throw refuse("cannot be read: there is no such file, or no permission");
  const std::string bytes((std::istreambuf_iterator<char>(file)), std::istreambuf_iterator<char>());
  if (!bytes.starts_with(run_state_kind))
    throw refuse("not a saved state of a run (`mimbre run --save-state` writes them)");
  if (!bytes.starts_with(run_state_mark))
    throw refuse(fmt::format("has layout '{}', this version of mimbre reads '{}'",
                             bytes.substr(0, run_state_mark.size()), run_state_mark));
  const auto damaged = [&] { return refuse("is damaged: use an older one, or run from the start"); };
  std::uint64_t sum = 0;
  if (bytes.size() < run_state_mark.size() + sizeof sum) throw damaged();
  const std::string_view content = std::string_view(bytes).substr(0, bytes.size() - sizeof sum);
  std::memcpy(&sum, bytes.data() + content.size(), sizeof sum);
  if (sum != hash_of(content)) throw damaged();
  RunState state;
  Reader in(content.substr(run_state_mark.size()));
  for_values(state, in);
  std::string snapshot;
  in(snapshot);
  if (!in.good()) throw damaged();
  try {
    state.snapshot = Simulation::Snapshot::from_bytes(std::as_bytes(std::span(snapshot)));
  } catch (const InputError& error) {
    throw refuse(error.diagnostics().front().message);
  }
  return state;
}

std::string file_when_whole(const std::string& file) { return target_of_part(file); }

}  // namespace mimbre
