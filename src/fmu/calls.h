#pragma once
#include <cfenv>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <mutex>
#include <span>
#include <string>
#include <vector>

#include "fmu/functions.h"
#include "fmu/plan.h"

namespace mimbre::fmu {

/// An instance of an FMU, and the calls of the standards in their order. It stands on the standard library
/// alone, since it also works in a process of its own. A call that fails returns false, and message() has the
/// reason; after that the instance is of no use. The state of the floating-point unit is kept.
class Calls {
 public:
  explicit Calls(Plan plan);
  ~Calls();
  Calls(const Calls&) = delete;
  Calls& operator=(const Calls&) = delete;

  /// Loads the library and makes the instance.
  bool open();
  /// Initialises it, where `intervals` is 0; else makes so many steps of `interval` up to `time` (s). Sizes
  /// of inputs and outputs are those of the plan.
  bool exchange(double time, double interval, std::int64_t intervals, const double* before, const double* in,
                double* out);
  bool save(std::vector<std::byte>& state);
  bool restore(std::span<const std::byte> state);

  const std::string& message() const { return message_; }
  std::string warning() const;

 private:
  /// A variable that is set or got as a whole.
  struct Variable {
    const Slot* slot;
    std::vector<double> values;
  };
  struct Place {
    std::size_t variable, element;
  };

  bool fail(const std::string& what);
  bool good(int status, const char* function);
  void* symbol(const char* name);
  template <class F>
  bool find(F& function, const char* name);
  bool begin(double time, const double* in);
  bool asks_for_the_end();
  bool step(double from, double interval);
  bool set_all(std::vector<Variable>& variables, const std::vector<Place>& places, const double* values);
  bool get_all(double* values);
  bool set_settings();
  bool set(const Slot& slot, const std::vector<double>& values);
  bool get(const Slot& slot, std::vector<double>& values);
  template <class T>
  bool set_as(const Slot& slot, const char* name, const std::vector<double>& values);
  template <class T>
  bool get_as(const Slot& slot, const char* name, std::vector<double>& values);
  bool set_text(const Setting& setting);
  void heard(int status, const char* category, const char* text);
  static void log2(void* environment, const char* instance, int status, const char* category,
                   const char* message, ...);
  static void log3(void* environment, int status, const char* category, const char* message);

  const Plan plan_;
  std::string message_;
  void* library_ = nullptr;
  void* instance_ = nullptr;
  bool initialised_ = false, failed_ = false, fatal_ = false;
  double steps_from_ = 0;  ///< s, where the FMU is
  std::vector<Variable> in_, out_;
  std::vector<Place> in_places_, out_places_;
  fmi2::Callbacks callbacks_{};
  mutable std::mutex log_guard_;
  std::deque<std::string> errors_;  ///< that the FMU told of, the last ones
  std::string first_warning_;
  std::int64_t warnings_ = 0;
  // Functions.
  void *get_[13] = {}, *set_[13] = {};  ///< by Type
  fmi2::Free free_ = nullptr;
  fmi2::Simple terminate_ = nullptr, exit_initialisation_ = nullptr, enter_initialisation_2_ = nullptr;
  fmi2::SetupExperiment setup_ = nullptr;
  fmi3::EnterInitialization enter_initialisation_3_ = nullptr;
  fmi2::DoStep do_step_2_ = nullptr;
  fmi3::DoStep do_step_3_ = nullptr;
  GetState get_state_ = nullptr;
  SetState set_state_ = nullptr;
  FreeState free_state_ = nullptr;
  SerializedSize serialized_size_ = nullptr;
  Serialize serialize_ = nullptr;
  Deserialize deserialize_ = nullptr;
};

}  // namespace mimbre::fmu
