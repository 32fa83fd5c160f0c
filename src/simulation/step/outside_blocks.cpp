#include "simulation/step/outside_blocks.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>

#include "mimbre/diagnostics.h"

namespace mimbre {
namespace {

/// Kinds of what is saved of a block.
enum class Saved : std::uint64_t { not_begun, state, none };

/// Saved states as words: for each block its kind, its number of bytes, and these.
class WordReader {
 public:
  explicit WordReader(std::span<const double> words) : words_(words) {}
  bool word(std::uint64_t& value) {
    if (words_.empty()) return false;
    std::memcpy(&value, words_.data(), sizeof value);
    words_ = words_.subspan(1);
    return true;
  }
  bool bytes(std::uint64_t count, std::vector<std::byte>& out) {
    if (count > words_.size() * sizeof(double)) return false;
    out.resize(count);
    if (count > 0) std::memcpy(out.data(), words_.data(), count);
    words_ = words_.subspan((count + sizeof(double) - 1) / sizeof(double));
    return true;
  }
  bool at_end() const { return words_.empty(); }

 private:
  std::span<const double> words_;
};

void add_word(std::vector<double>& words, std::uint64_t value) {
  words.emplace_back();
  std::memcpy(&words.back(), &value, sizeof value);
}

const char* not_finite(double x) { return std::isnan(x) ? "not a number" : "infinite"; }

std::string not_saved_text(const spec::Block& block) {
  const std::string why = block.outside->not_saved();
  return why.empty() ? why
                     : fmt::format("the state of signal '{}' ({}) cannot be saved: {}", block.name,
                                   block.outside->label(), why);
}

}  // namespace

OutsideBlocks::OutsideBlocks(const Compiled& model, double step) : model_(model) {
  for (std::size_t k = 0; k < model.spec().blocks.size(); ++k) {
    const spec::Block& block = model.spec().blocks[k];
    if (!block.outside) continue;
    const double steps = block.every / step;
    if (std::abs(steps - std::round(steps)) > 1e-6 * steps)
      throw InputError(
          block.mark,
          fmt::format("signal '{}': {} is called every {} s, which is no whole number of steps of "
                      "{} s; choose a multiple",
                      block.name, block.outside->label(), block.every, step));
    blocks_.push_back({&block, static_cast<int>(k), model.signals.blocks[k].held, nullptr});
  }
  for (Block& block : blocks_) make_anew(block);
}

void OutsideBlocks::make_anew(Block& block) {
  block.instance = nullptr;  // first: there may be only one
  try {
    block.instance = block.spec->outside->instantiate(block.spec->name);
  } catch (const InputError& error) {
    throw InputError(block.spec->mark, fmt::format("signal '{}': {}", block.spec->name, error.what()));
  }
  block.begun = block.failed = false;
}

bool OutsideBlocks::exchange(const SignalsData::Sampled& sampled, const double* in, double made, State& state,
                             double* out) {
  Block& block =
      *std::find_if(blocks_.begin(), blocks_.end(), [&](const Block& b) { return b.index == sampled.block; });
  const SignalsData::Block& data = model_.signals.blocks[static_cast<std::size_t>(sampled.block)];
  double* held = state.u.data() + block.held;
  const auto multiple = [&](double time) { return std::floor(time / sampled.every + 1e-6); };
  OutsideInstance::Instant instant;
  instant.interval = sampled.every;
  instant.time = multiple(state.time) * sampled.every;
  instant.intervals = held[0] > 0.5 ? static_cast<std::int64_t>(multiple(state.time) - multiple(made)) : 0;
  instant.before = held + 1;
  instant.in = in;
  instant.out = out;
  const auto failed = [&](const std::string& why) {
    block.failed = true;
    failure_ = fmt::format("signal '{}': {} failed at t = {:.6g} s: {}", block.spec->name,
                           block.spec->outside->label(), state.time, why);
    return false;
  };
  if (!failure_.empty() && block.failed) return false;
  for (int k = 0; k < data.inputs; ++k)
    if (!std::isfinite(in[k])) return failed(fmt::format("its input {} is {}", k + 1, not_finite(in[k])));
  if (!block.instance->exchange(instant)) return failed(block.instance->message());
  for (int k = 0; k < data.outputs; ++k)
    if (!std::isfinite(out[k])) return failed(fmt::format("its output {} is {}", k + 1, not_finite(out[k])));
  held[0] = 1;
  std::copy_n(in, data.inputs, held + 1);
  block.begun = true;
  return true;
}

std::string OutsideBlocks::not_saved() const {
  for (const Block& block : blocks_)
    if (std::string why = not_saved_text(*block.spec); !why.empty()) return why;
  return {};
}

std::vector<std::string> OutsideBlocks::warnings() const {
  std::vector<std::string> all;
  for (const Block& block : blocks_)
    if (const std::string text = block.instance->warning(); !text.empty())
      all.push_back(fmt::format("signal '{}': {} {}", block.spec->name, block.spec->outside->label(), text));
  return all;
}

std::vector<double> OutsideBlocks::save() const {
  std::vector<double> words;
  std::vector<std::byte> bytes;
  for (const Block& block : blocks_) {
    bytes.clear();
    const bool saved = block.begun && !block.failed && block.spec->outside->not_saved().empty() &&
                       block.instance->save(bytes);
    if (!saved) bytes.clear();
    add_word(words, static_cast<std::uint64_t>(!block.begun ? Saved::not_begun
                                               : saved      ? Saved::state
                                                            : Saved::none));
    add_word(words, bytes.size());
    const std::size_t first = words.size();
    words.resize(first + (bytes.size() + sizeof(double) - 1) / sizeof(double), 0.0);
    if (!bytes.empty()) std::memcpy(words.data() + first, bytes.data(), bytes.size());
  }
  return words;
}

void OutsideBlocks::check(std::span<const double> states) const {
  WordReader reader(states);
  std::vector<std::byte> bytes;
  for (const Block& block : blocks_) {
    std::uint64_t kind = 0, count = 0;
    if (!reader.word(kind) || !reader.word(count) || !reader.bytes(count, bytes) ||
        kind > static_cast<std::uint64_t>(Saved::none))
      throw InputError(Mark{}, fmt::format("the saved state is damaged: that of signal '{}' is not whole",
                                           block.spec->name));
    if (kind != static_cast<std::uint64_t>(Saved::none)) continue;
    const std::string why = not_saved_text(*block.spec);
    throw InputError(Mark{},
                     why.empty()
                         ? fmt::format("the saved state lacks that of signal '{}' ({}), which had failed or "
                                       "refused to save it",
                                       block.spec->name, block.spec->outside->label())
                         : why + "; run from the start");
  }
  if (!reader.at_end()) throw InputError(Mark{}, "the saved state has more blocks than the model");
}

void OutsideBlocks::restore(std::span<const double> states) {
  WordReader reader(states);
  std::vector<std::byte> bytes;
  failure_.clear();
  for (Block& block : blocks_) {
    std::uint64_t kind = 0, count = 0;
    reader.word(kind);
    reader.word(count);
    reader.bytes(count, bytes);
    if (kind != static_cast<std::uint64_t>(Saved::state)) {
      if (block.begun || block.failed) make_anew(block);
      continue;
    }
    if (block.failed) make_anew(block);
    if (!block.instance->restore(bytes)) {
      block.failed = true;
      throw InputError(block.spec->mark,
                       fmt::format("signal '{}': {} does not take back its state: {}", block.spec->name,
                                   block.spec->outside->label(), block.instance->message()));
    }
    block.begun = true;
  }
}

void OutsideBlocks::restart(State& state) {
  failure_.clear();
  for (Block& block : blocks_) {
    if (block.begun || block.failed) make_anew(block);
    state.u[block.held] = 0;
  }
}

}  // namespace mimbre
