#pragma once
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

/// Blocks of signals that are computed by code from elsewhere, such as an FMU (mimbre/fmu_import.h): how the
/// simulation calls them.
namespace mimbre {

/// Most inputs, and most outputs, of such a block.
constexpr int most_outside_values = 64;

/// A block at work in one simulation. One thread at a time. Nothing is thrown: a call that fails returns
/// false, and message() has the reason.
class OutsideInstance {
 public:
  virtual ~OutsideInstance() = default;

  /// What an instant brings.
  struct Instant {
    double time = 0;             ///< s, a multiple of the interval; where it begins, the time of the start
    double interval = 0;         ///< s, from one instant to the next
    std::int64_t intervals = 0;  ///< since the last call; 0: the block begins here
    const double* before = nullptr;  ///< inputs at the last call
    const double* in = nullptr;      ///< inputs now
    double* out = nullptr;           ///< to be filled
  };
  virtual bool exchange(const Instant& instant) = 0;

  /// Appends all that the next calls depend on.
  virtual bool save(std::vector<std::byte>& state) = 0;
  /// Goes on from what save() wrote, of this or another instance of the same block, in any process.
  virtual bool restore(std::span<const std::byte> state) = 0;

  /// Why the last call failed.
  virtual std::string message() const = 0;
  /// What it warned of so far; empty: of nothing.
  virtual std::string warning() const { return {}; }
};

/// The description of such a block: const, and shared by simulations and threads.
class OutsideBlock {
 public:
  virtual ~OutsideBlock() = default;

  /// For messages: "FMU 'controller.fmu'".
  virtual std::string label() const = 0;
  virtual int inputs() const = 0;
  virtual int outputs() const = 0;
  /// A number that changes with its content and with all that was chosen for it.
  virtual std::uint64_t identity() const = 0;
  /// Why its state cannot be saved; empty: it can.
  virtual std::string not_saved() const = 0;
  /// A new instance, which has not begun. Throws InputError with the reason. `name`: the signal's.
  virtual std::unique_ptr<OutsideInstance> instantiate(const std::string& name) const = 0;
};

}  // namespace mimbre
