#include "fmu/calls.h"

#include <dlfcn.h>

#include <cinttypes>
#include <cmath>
#include <cstdarg>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <limits>
#include <memory>

namespace mimbre::fmu {
namespace {

/// Rounding, exceptions and flushing of small numbers are as before when it goes.
class KeepFloatingPoint {
 public:
  KeepFloatingPoint() { std::fegetenv(&kept_); }
  ~KeepFloatingPoint() { std::fesetenv(&kept_); }
  KeepFloatingPoint(const KeepFloatingPoint&) = delete;
  KeepFloatingPoint& operator=(const KeepFloatingPoint&) = delete;

 private:
  std::fenv_t kept_;
};

constexpr std::size_t most_errors = 4, longest_text = 400;
constexpr std::size_t largest_state = std::size_t{1} << 30;

/// Names in the functions of FMI 3; those of FMI 2 are Real, Integer, Boolean, String.
constexpr const char* type_names[] = {"Float64", "Float32", "Int8",   "UInt8",   "Int16",  "UInt16", "Int32",
                                      "UInt32",  "Int64",   "UInt64", "Boolean", "String", "other"};

const char* name_of(Type type, int version) {
  if (version == 3) return type_names[static_cast<std::size_t>(type)];
  return type == Type::float64 ? "Real"
         : type == Type::int32 ? "Integer"
                               : type_names[static_cast<std::size_t>(type)];
}

const char* name_of_status(int status) {
  constexpr const char* names[] = {"OK", "Warning", "Discard", "Error", "Fatal", "Pending"};
  return status >= 0 && status <= Status::pending ? names[status]
                                                  : "a status that the standard does not have";
}

std::string shortened(const char* text) {
  std::string result;
  for (std::size_t k = 0; text && text[k] != '\0' && k < longest_text; ++k)
    result += static_cast<unsigned char>(text[k]) < 32 ? ' ' : text[k];
  while (!result.empty() && result.back() == ' ') result.pop_back();
  return result;
}

std::string number_text(double x) {
  char text[40];
  std::snprintf(text, sizeof text, "%.6g", x);
  return text;
}

/// "file:///tmp/a%20b"
std::string uri_of(const std::string& path) {
  std::string uri = "file://";
  for (const char c : path) {
    const bool plain = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') ||
                       std::strchr("/-_.~", c) != nullptr;
    char text[4];
    std::snprintf(text, sizeof text, "%%%02X", static_cast<unsigned char>(c));
    uri += plain ? std::string(1, c) : std::string(text);
  }
  return uri;
}

/// A whole number of the type; false where it is none.
template <class T>
bool whole(double x, T& result) {
  const double rounded = std::round(x);
  // 2^63 and 2^64 are numbers, the largest of the types are not.
  if (!(rounded >= static_cast<double>(std::numeric_limits<T>::min()) &&
        rounded < std::ldexp(1.0, std::numeric_limits<T>::digits)))
    return false;
  result = static_cast<T>(rounded);
  return true;
}

/// The interpreter of Python for libraries that expect the process to have it, as those of pythonfmu do: the
/// newest that the system finds. False where there is none.
bool load_python() {
  for (int minor = 20; minor >= 6; --minor)
    if (dlopen(("libpython3." + std::to_string(minor) + ".so.1.0").c_str(), RTLD_NOW | RTLD_GLOBAL))
      return true;
  return false;
}

void* load_library(const std::string& path, std::string& why) {
  void* library = dlopen(path.c_str(), RTLD_NOW | RTLD_LOCAL);
  if (library) return library;
  why = shortened(dlerror());
  if (why.find("undefined symbol: Py") == std::string::npos &&
      why.find("undefined symbol: _Py") == std::string::npos)
    return nullptr;
  if (!load_python()) {
    why += " (it needs Python in the process, and no libpython3 is found: install it, or run it from Python)";
    return nullptr;
  }
  library = dlopen(path.c_str(), RTLD_NOW | RTLD_LOCAL);
  if (!library) why = shortened(dlerror());
  return library;
}

/// Places of slots in the variables that they belong to.
template <class Variables, class Places>
void gather(const std::vector<Slot>& slots, Variables& variables, Places& places) {
  for (const Slot& slot : slots) {
    std::size_t k = 0;
    while (k < variables.size() && variables[k].slot->name != slot.name) ++k;
    if (k == variables.size()) variables.push_back({&slot, slot.start});
    places.push_back({k, static_cast<std::size_t>(slot.element)});
  }
}

}  // namespace

Calls::Calls(Plan plan) : plan_(std::move(plan)) {
  gather(plan_.inputs, in_, in_places_);
  gather(plan_.outputs, out_, out_places_);
}

Calls::~Calls() {
  if (!instance_ || fatal_) return;
  const KeepFloatingPoint keep;
  if (initialised_ && !failed_ && terminate_) terminate_(instance_);
  if (free_ && !fatal_) free_(instance_);
  // The library stays: many a one does not stand being unloaded.
}

bool Calls::fail(const std::string& what) {
  failed_ = true;
  message_ = what;
  const std::lock_guard guard(log_guard_);
  const char* separator = ": ";
  for (const std::string& text : errors_) {
    message_ += separator + text;
    separator = "; ";
  }
  errors_.clear();
  return false;
}

bool Calls::good(int status, const char* function) {
  if (status == Status::ok || status == Status::warning) return true;
  if (status == Status::fatal) fatal_ = true;
  const std::string name = "fmi" + std::to_string(plan_.version) + function;
  if (status == Status::pending && plan_.version == 2)
    return fail(name +
                " is not finished when it returns, and FMUs whose steps go on by themselves are not called");
  return fail(name + " returned " +
              (status >= 0 && status <= Status::pending ? "fmi" + std::to_string(plan_.version) : "") +
              name_of_status(status));
}

void* Calls::symbol(const char* name) {
  const std::string full = "fmi" + std::to_string(plan_.version) + name;
  if (void* found = dlsym(library_, full.c_str())) return found;
  // As sources name them that are meant for static linking.
  return dlsym(library_, (plan_.identifier + "_" + full).c_str());
}

template <class F>
bool Calls::find(F& function, const char* name) {
  function = reinterpret_cast<F>(symbol(name));
  return function || fail("its library lacks the function fmi" + std::to_string(plan_.version) + name);
}

bool Calls::open() {
  const KeepFloatingPoint keep;
  std::string why;
  library_ = load_library(plan_.binary, why);
  if (!library_) return fail("its library cannot be loaded: " + why);
  const bool three = plan_.version == 3;
  fmi2::GetText version = nullptr;
  bool there = find(version, "GetVersion") && find(free_, "FreeInstance") && find(terminate_, "Terminate") &&
               find(exit_initialisation_, "ExitInitializationMode");
  if (three)
    there = there && find(enter_initialisation_3_, "EnterInitializationMode") && find(do_step_3_, "DoStep");
  else
    there = there && find(setup_, "SetupExperiment") &&
            find(enter_initialisation_2_, "EnterInitializationMode") && find(do_step_2_, "DoStep");
  const auto accessor = [&](void*& function, const char* verb, Type type) {
    return function || find(function, (std::string(verb) + name_of(type, plan_.version)).c_str());
  };
  for (const Slot& slot : plan_.inputs)
    there = there && accessor(set_[static_cast<std::size_t>(slot.type)], "Set", slot.type);
  for (const Setting& setting : plan_.settings)
    there = there && accessor(set_[static_cast<std::size_t>(setting.type)], "Set", setting.type);
  for (const Slot& slot : plan_.outputs)
    there = there && accessor(get_[static_cast<std::size_t>(slot.type)], "Get", slot.type);
  const char* const state = three ? "FMUState" : "FMUstate";
  const auto with_state = [&](const char* before) { return std::string(before) + state; };
  if (plan_.saves)
    there = there && find(get_state_, with_state("Get").c_str()) &&
            find(set_state_, with_state("Set").c_str()) && find(free_state_, with_state("Free").c_str()) &&
            find(serialized_size_, three ? "SerializedFMUStateSize" : "SerializedFMUstateSize") &&
            find(serialize_, with_state("Serialize").c_str()) &&
            find(deserialize_, three ? "DeserializeFMUState" : "DeSerializeFMUstate");
  if (!there) return false;
  const std::string says = shortened(version());
  if (says.rfind(three ? "3." : "2.", 0) != 0)
    return fail("its library is of FMI '" + says + "', its description of FMI " +
                std::to_string(plan_.version));
  if (three) {
    fmi3::Instantiate make = nullptr;
    if (!find(make, "InstantiateCoSimulation")) return false;
    instance_ = make(plan_.instance.c_str(), plan_.token.c_str(),
                     plan_.resources.empty() ? nullptr : (plan_.resources + "/").c_str(), false, true, false,
                     false, nullptr, 0, this, log3, nullptr);
  } else {
    fmi2::Instantiate make = nullptr;
    if (!find(make, "Instantiate")) return false;
    callbacks_ = {log2, std::calloc, std::free, nullptr, this};
    constexpr int co_simulation = 1;
    instance_ = make(plan_.instance.c_str(), co_simulation, plan_.token.c_str(),
                     uri_of(plan_.resources).c_str(), &callbacks_, 0, 1);
  }
  return instance_ || fail(three ? "fmi3InstantiateCoSimulation returned no instance"
                                 : "fmi2Instantiate returned no instance");
}

bool Calls::exchange(double time, double interval, std::int64_t intervals, const double* before,
                     const double* in, double* out) {
  if (failed_) return false;
  if (!instance_) return fail("has no instance");
  const KeepFloatingPoint keep;
  if (intervals <= 0) return begin(time, in) && get_all(out);
  if (!initialised_) return fail("was not initialised");
  // Between setting inputs and getting outputs there is always a step: FMI 2 asks for it.
  if (!set_all(in_, in_places_, plan_.inputs_of_the_end ? in : before)) return false;
  for (std::int64_t k = intervals; k > 0; --k)
    if (!step(time - static_cast<double>(k) * interval, interval)) return false;
  return get_all(out);
}

bool Calls::begin(double time, const double* in) {
  if (initialised_) return fail("is initialised already");
  if (!set_settings()) return false;
  if (plan_.version == 3) {
    if (!good(enter_initialisation_3_(instance_, false, 0, time, false, 0), "EnterInitializationMode"))
      return false;
  } else if (!good(setup_(instance_, 0, 0, time, 0, 0), "SetupExperiment") ||
             !good(enter_initialisation_2_(instance_), "EnterInitializationMode")) {
    return false;
  }
  if (!set_all(in_, in_places_, in)) return false;
  if (!good(exit_initialisation_(instance_), "ExitInitializationMode")) return false;
  initialised_ = true;
  return true;
}

/// Of FMI 2, where a step was discarded.
bool Calls::asks_for_the_end() {
  constexpr int terminated = 3;
  int flag = 0;
  const auto ask = reinterpret_cast<int (*)(void*, int, int*)>(symbol("GetBooleanStatus"));
  return ask && ask(instance_, terminated, &flag) == Status::ok && flag != 0;
}

bool Calls::step(double from, double interval) {
  if (plan_.version == 2) {
    const int status = do_step_2_(instance_, from, interval, plan_.saves ? 0 : 1);
    if (status == Status::discard && asks_for_the_end())
      return fail("asks for the end of the simulation in its step from t = " + number_text(from) + " s");
    return good(status, "DoStep");
  }
  bool event = false, terminate = false, early = false;
  double last = from + interval;
  const int status = do_step_3_(instance_, from, interval, !plan_.saves, &event, &terminate, &early, &last);
  if (!good(status, "DoStep")) return false;
  if (terminate) return fail("asks for the end of the simulation at t = " + number_text(last) + " s");
  if (early)
    return fail("returned from its step early, at t = " + number_text(last) + " s, which it must not");
  return true;
}

bool Calls::set_all(std::vector<Variable>& variables, const std::vector<Place>& places,
                    const double* values) {
  for (std::size_t k = 0; k < places.size(); ++k)
    variables[places[k].variable].values[places[k].element] = values[k];
  for (const Variable& v : variables)
    if (!set(*v.slot, v.values)) return false;
  return true;
}

bool Calls::get_all(double* values) {
  for (Variable& v : out_)
    if (!get(*v.slot, v.values)) return false;
  for (std::size_t k = 0; k < out_places_.size(); ++k)
    values[k] = out_[out_places_[k].variable].values[out_places_[k].element];
  return true;
}

template <class T>
bool Calls::set_as(const Slot& slot, const char* name, const std::vector<double>& values) {
  constexpr std::size_t few = 8;
  T room[few];
  const std::unique_ptr<T[]> more(values.size() > few ? new T[values.size()]() : nullptr);
  T* const converted = values.size() > few ? more.get() : room;
  for (std::size_t k = 0; k < values.size(); ++k) {
    if constexpr (std::is_integral_v<T>) {
      if (!whole(values[k], converted[k]))
        return fail("variable '" + slot.name + "' cannot be " + number_text(values[k]) + ": it is " +
                    name_of(slot.type, plan_.version));
    } else {
      converted[k] = static_cast<T>(values[k]);
    }
  }
  void* const function = set_[static_cast<std::size_t>(slot.type)];
  const int status =
      plan_.version == 3
          ? reinterpret_cast<fmi3::Set<T>>(function)(instance_, &slot.reference, 1, converted, values.size())
          : reinterpret_cast<fmi2::Set<T>>(function)(instance_, &slot.reference, 1, converted);
  if (status == Status::ok) return true;
  return good(status, (std::string("Set") + name + " of '" + slot.name + "'").c_str());
}

template <class T>
bool Calls::get_as(const Slot& slot, const char* name, std::vector<double>& values) {
  constexpr std::size_t few = 8;
  T room[few] = {};
  const std::unique_ptr<T[]> more(values.size() > few ? new T[values.size()]() : nullptr);
  T* const got = values.size() > few ? more.get() : room;
  void* const function = get_[static_cast<std::size_t>(slot.type)];
  const int status =
      plan_.version == 3
          ? reinterpret_cast<fmi3::Get<T>>(function)(instance_, &slot.reference, 1, got, values.size())
          : reinterpret_cast<fmi2::Get<T>>(function)(instance_, &slot.reference, 1, got);
  if (status != Status::ok && !good(status, (std::string("Get") + name + " of '" + slot.name + "'").c_str()))
    return false;
  for (std::size_t k = 0; k < values.size(); ++k) values[k] = static_cast<double>(got[k]);
  return true;
}

bool Calls::set(const Slot& slot, const std::vector<double>& values) {
  const char* const name = name_of(slot.type, plan_.version);
  switch (slot.type) {
    case Type::float64:
      return set_as<double>(slot, name, values);
    case Type::float32:
      return set_as<float>(slot, name, values);
    case Type::int8:
      return set_as<std::int8_t>(slot, name, values);
    case Type::uint8:
      return set_as<std::uint8_t>(slot, name, values);
    case Type::int16:
      return set_as<std::int16_t>(slot, name, values);
    case Type::uint16:
      return set_as<std::uint16_t>(slot, name, values);
    case Type::int32:
      return set_as<std::int32_t>(slot, name, values);
    case Type::uint32:
      return set_as<std::uint32_t>(slot, name, values);
    case Type::int64:
      return set_as<std::int64_t>(slot, name, values);
    case Type::uint64:
      return set_as<std::uint64_t>(slot, name, values);
    case Type::boolean: {
      std::vector<double> flags = values;
      for (double& x : flags) x = x > 0.5 ? 1 : 0;
      // fmi2Boolean is an int, fmi3Boolean a bool.
      return plan_.version == 3 ? set_as<std::uint8_t>(slot, name, flags)
                                : set_as<std::int32_t>(slot, name, flags);
    }
    case Type::string:
    case Type::other:
      break;
  }
  return fail("variable '" + slot.name + "' is no number");
}

bool Calls::get(const Slot& slot, std::vector<double>& values) {
  const char* const name = name_of(slot.type, plan_.version);
  switch (slot.type) {
    case Type::float64:
      return get_as<double>(slot, name, values);
    case Type::float32:
      return get_as<float>(slot, name, values);
    case Type::int8:
      return get_as<std::int8_t>(slot, name, values);
    case Type::uint8:
      return get_as<std::uint8_t>(slot, name, values);
    case Type::int16:
      return get_as<std::int16_t>(slot, name, values);
    case Type::uint16:
      return get_as<std::uint16_t>(slot, name, values);
    case Type::int32:
      return get_as<std::int32_t>(slot, name, values);
    case Type::uint32:
      return get_as<std::uint32_t>(slot, name, values);
    case Type::int64:
      return get_as<std::int64_t>(slot, name, values);
    case Type::uint64:
      return get_as<std::uint64_t>(slot, name, values);
    case Type::boolean:
      return plan_.version == 3 ? get_as<std::uint8_t>(slot, name, values)
                                : get_as<std::int32_t>(slot, name, values);
    case Type::string:
    case Type::other:
      break;
  }
  return fail("variable '" + slot.name + "' is no number");
}

bool Calls::set_text(const Setting& setting) {
  std::vector<const char*> texts;
  for (const std::string& value : setting.values) texts.push_back(value.c_str());
  void* const function = set_[static_cast<std::size_t>(Type::string)];
  const int status = plan_.version == 3 ? reinterpret_cast<fmi3::Set<const char*>>(function)(
                                              instance_, &setting.reference, 1, texts.data(), texts.size())
                                        : reinterpret_cast<fmi2::Set<const char*>>(function)(
                                              instance_, &setting.reference, 1, texts.data());
  return good(status, ("SetString of '" + setting.name + "'").c_str());
}

bool Calls::set_settings() {
  for (const Setting& setting : plan_.settings) {
    if (setting.type == Type::string) {
      if (!set_text(setting)) return false;
      continue;
    }
    Slot slot;
    slot.name = setting.name;
    slot.reference = setting.reference;
    slot.type = setting.type;
    std::vector<double> values;
    for (const std::string& value : setting.values) values.push_back(std::strtod(value.c_str(), nullptr));
    if (!set(slot, values)) return false;
  }
  return true;
}

bool Calls::save(std::vector<std::byte>& state) {
  if (failed_ || !instance_) return false;
  const KeepFloatingPoint keep;
  if (!plan_.saves) return fail("cannot save its state");
  void* now = nullptr;
  if (!good(get_state_(instance_, &now), "GetFMUState")) return false;
  std::size_t size = 0;
  bool done = good(serialized_size_(instance_, now, &size), "SerializedFMUStateSize");
  if (done && size > largest_state)
    done = fail("reports a state of " + std::to_string(size) + " bytes; 1 GiB is the most that is saved");
  if (done) {
    const std::size_t first = state.size();
    state.resize(first + size);
    done = good(serialize_(instance_, now, reinterpret_cast<std::uint8_t*>(state.data() + first), size),
                "SerializeFMUState");
  }
  if (!fatal_) free_state_(instance_, &now);
  return done;
}

bool Calls::restore(std::span<const std::byte> state) {
  if (failed_ || !instance_) return false;
  const KeepFloatingPoint keep;
  if (!plan_.saves) return fail("cannot take back a state");
  void* then = nullptr;
  if (!good(deserialize_(instance_, reinterpret_cast<const std::uint8_t*>(state.data()), state.size(), &then),
            "DeserializeFMUState"))
    return false;
  const bool done = good(set_state_(instance_, then), "SetFMUState");
  if (!fatal_) free_state_(instance_, &then);
  initialised_ = true;
  return done;
}

std::string Calls::warning() const {
  const std::lock_guard guard(log_guard_);
  if (warnings_ == 0) return {};
  return "warned " + (warnings_ == 1 ? std::string("once") : std::to_string(warnings_) + " times") +
         ", first: " + first_warning_;
}

void Calls::heard(int status, const char* category, const char* text) {
  if (status == Status::ok) return;
  std::string said = shortened(text);
  if (said.empty()) said = shortened(category);
  const std::lock_guard guard(log_guard_);
  if (status == Status::warning) {
    if (warnings_++ == 0) first_warning_ = said;
    return;
  }
  errors_.push_back(said);
  if (errors_.size() > most_errors) errors_.pop_front();
}

void Calls::log2(void* environment, const char*, int status, const char* category, const char* message, ...) {
  if (!environment || status == Status::ok) return;
  char text[2 * longest_text] = "";
  va_list arguments;
  va_start(arguments, message);
  if (message) std::vsnprintf(text, sizeof text, message, arguments);
  va_end(arguments);
  static_cast<Calls*>(environment)->heard(status, category, text);
}

void Calls::log3(void* environment, int status, const char* category, const char* message) {
  if (environment) static_cast<Calls*>(environment)->heard(status, category, message);
}

}  // namespace mimbre::fmu
