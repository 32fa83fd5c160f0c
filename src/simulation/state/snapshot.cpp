#include <fmt/format.h>

#include <array>
#include <cstring>
#include <string_view>

#include "base/hash64.h"
#include "mimbre/simulation.h"

namespace mimbre {
namespace {

/// Ends with the number of the layout.
constexpr std::string_view snapshot_mark = "mimbre-state-001";
constexpr std::string_view snapshot_kind = snapshot_mark.substr(0, 13);
constexpr std::size_t vectors = 9;

template <class Snapshot>
auto vectors_of(Snapshot& s) {
  return std::array{&s.q, &s.v, &s.a, &s.algorithmic, &s.multipliers, &s.z, &s.u, &s.marks, &s.memory};
}

std::string_view text(std::span<const std::byte> bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

std::uint64_t checksum(std::span<const std::byte> bytes) {
  Hash64 hash;
  hash.add(text(bytes));
  return hash.value();
}

[[noreturn]] void refuse_snapshot(const std::string& why) {
  throw InputError(Mark{}, "the saved state " + why);
}

}  // namespace

/// Mark, fingerprint, sizes, numbers, checksum; all of them words of eight bytes in the machine's order.
std::vector<std::byte> Simulation::Snapshot::bytes() const {
  std::vector<std::byte> out;
  const auto put = [&](const void* from, std::size_t count) {
    const auto* const first = static_cast<const std::byte*>(from);
    out.insert(out.end(), first, first + count);
  };
  const auto word = [&](std::uint64_t value) { put(&value, sizeof value); };
  const auto number = [&](double value) { put(&value, sizeof value); };
  put(snapshot_mark.data(), snapshot_mark.size());
  word(model);
  for (const Eigen::VectorXd* x : vectors_of(*this)) word(static_cast<std::uint64_t>(x->size()));
  number(time);
  number(energy_error);
  word(started ? 1 : 0);
  for (const Eigen::VectorXd* x : vectors_of(*this))
    put(x->data(), static_cast<std::size_t>(x->size()) * sizeof(double));
  word(checksum(out));
  return out;
}

Simulation::Snapshot Simulation::Snapshot::from_bytes(std::span<const std::byte> bytes) {
  if (!text(bytes).starts_with(snapshot_kind))
    refuse_snapshot("is no saved state: it begins with other bytes");
  if (!text(bytes).starts_with(snapshot_mark))
    refuse_snapshot(fmt::format("has another layout ('{}') than this version of mimbre reads ('{}')",
                                text(bytes).substr(0, snapshot_mark.size()), snapshot_mark));
  std::size_t at = snapshot_mark.size();
  const auto take = [&](void* to, std::size_t count) {
    if (bytes.size() - at < count) refuse_snapshot("is damaged: it is cut short");
    std::memcpy(to, bytes.data() + at, count);
    at += count;
  };
  const auto word = [&] {
    std::uint64_t value = 0;
    take(&value, sizeof value);
    return value;
  };
  Snapshot s;
  s.model = word();
  std::array<std::uint64_t, vectors> sizes{};
  for (std::uint64_t& size : sizes) size = word();
  take(&s.time, sizeof s.time);
  take(&s.energy_error, sizeof s.energy_error);
  s.started = word() != 0;
  std::size_t k = 0;
  for (Eigen::VectorXd* x : vectors_of(s)) {
    const std::uint64_t size = sizes[k++];
    if (size > (bytes.size() - at) / sizeof(double)) refuse_snapshot("is damaged: it is cut short");
    x->resize(static_cast<Eigen::Index>(size));
    take(x->data(), size * sizeof(double));
  }
  const std::uint64_t sum = checksum(bytes.first(at));
  if (word() != sum || at != bytes.size()) refuse_snapshot("is damaged: its checksum is wrong");
  return s;
}

}  // namespace mimbre
