#pragma once
#include <dlfcn.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include "mimbre/fmu.h"

/// A program that imports FMUs, of both versions of the standard, for tests.
namespace mimbre::test {

enum FmiStatus : int { fmi_ok, fmi_warning, fmi_discard, fmi_error, fmi_fatal };

/// A folder of this process alone, so that two runs of the tests do not meet; removed at its end.
inline const std::string& fmu_folder() {
  struct Folder {
    std::string path = testing::TempDir() + "fmu_" + std::to_string(getpid()) + "/";
    Folder() { std::filesystem::create_directories(path); }
    ~Folder() {
      std::error_code ignored;
      std::filesystem::remove_all(path, ignored);
    }
  };
  static const Folder folder;
  return folder.path;
}

/// What a command prints; it has to succeed.
inline std::string printed_by(const std::string& command) {
  const std::string file = fmu_folder() + "printed";
  EXPECT_EQ(std::system((command + " > " + file + " 2>&1").c_str()), 0) << command;
  std::stringstream text;
  text << std::ifstream(file).rdbuf();
  std::filesystem::remove(file);
  return text.str();
}

/// The sources in a folder.
inline std::string fmu_sources(const FmuCode& fmu, const std::string& label) {
  const std::string folder = fmu_folder() + label + "_" + fmu.code.name + std::to_string(fmu.version);
  write_code(fmu.code, folder);
  std::ofstream(folder + "/fmi" + std::to_string(fmu.version) + ".c") << fmu.wrapper;
  return folder;
}

inline unsigned reference(const FmuCode& fmu, const std::string& name) {
  for (const FmuVariable& v : fmu.variables)
    if (v.name == name) return v.reference;
  throw std::runtime_error("no variable " + name);
}
/// Of all variables of these roles.
inline std::vector<unsigned> references(const FmuCode& fmu, const std::set<FmuVariable::Role>& roles) {
  std::vector<unsigned> out;
  for (const FmuVariable& v : fmu.variables)
    if (roles.contains(v.role)) out.push_back(v.reference);
  return out;
}

/// A compiled FMU, loaded.
class FmuLibrary {
 public:
  explicit FmuLibrary(FmuCode fmu, const std::string& label) : fmu_(std::move(fmu)) {
    const std::string folder = fmu_sources(fmu_, label), file = folder + "/library.so";
    EXPECT_EQ(
        printed_by("cc -std=c99 -O0 -Wall -Wextra -Wpedantic -Werror -fPIC -shared -fvisibility=hidden -o " +
                   file + " " + folder + "/" + fmu_.code.name + ".c " + folder + "/fmi" +
                   std::to_string(fmu_.version) + ".c -lm"),
        "");
    library_ = dlopen(file.c_str(), RTLD_NOW | RTLD_LOCAL);
    if (!library_) throw std::runtime_error(dlerror());
  }
  ~FmuLibrary() { dlclose(library_); }
  FmuLibrary(const FmuLibrary&) = delete;
  FmuLibrary& operator=(const FmuLibrary&) = delete;

  const FmuCode& fmu() const { return fmu_; }
  bool two() const { return fmu_.version == 2; }

  /// Calls a function by its name without fmi2 or fmi3; arguments have the types of the standard.
  template <class Result = int, class... Arguments>
  Result call(const std::string& name, Arguments... arguments) const {
    void* const found = dlsym(library_, ((two() ? "fmi2" : "fmi3") + name).c_str());
    if (!found) throw std::runtime_error("the FMU has no function " + name);
    return reinterpret_cast<Result (*)(Arguments...)>(found)(arguments...);
  }
  bool has(const std::string& name) const { return dlsym(library_, name.c_str()) != nullptr; }

 private:
  FmuCode fmu_;
  void* library_ = nullptr;
};

/// Messages and memory of FMI 2, and messages of FMI 3.
struct FmuCallbacks {
  void (*logger)(void*, const char*, int, const char*, const char*, ...) = nullptr;
  void* (*allocate)(std::size_t, std::size_t) = std::calloc;
  void (*release)(void*) = std::free;
  void (*finished)(void*, int) = nullptr;
  void* environment = nullptr;
};

/// An instance.
class FmuInstance {
 public:
  explicit FmuInstance(const FmuLibrary& library, FmuCallbacks callbacks = {}, const char* token = nullptr,
                       const char* name = "one")
      : library_(library), callbacks_(callbacks) {
    if (!token) token = library.fmu().token.c_str();
    callbacks_.logger = &FmuInstance::log2;
    callbacks_.environment = this;
    const bool exchange = library.fmu().kind == FmuOptions::Kind::model_exchange;
    c_ = library.two() ? library.call<void*>("Instantiate", name, exchange ? 0 : 1, token, "",
                                             static_cast<const FmuCallbacks*>(&callbacks_), 0, 1)
         : exchange    ? library.call<void*>("InstantiateModelExchange", name, token, "", false, true,
                                          static_cast<void*>(this), &FmuInstance::log3)
                       : library.call<void*>("InstantiateCoSimulation", name, token, "", false, true, false,
                                          false, static_cast<const unsigned*>(nullptr), std::size_t{0},
                                          static_cast<void*>(this), &FmuInstance::log3,
                                          static_cast<void (*)()>(nullptr));
  }
  ~FmuInstance() { library_.call<void>("FreeInstance", c_); }
  FmuInstance(const FmuInstance&) = delete;
  FmuInstance& operator=(const FmuInstance&) = delete;

  void* handle() const { return c_; }
  const std::string& messages() const { return messages_; }

  int enter(double start = 0, bool has_stop = false, double stop = 0) {
    if (!library_.two())
      return library_.call("EnterInitializationMode", c_, false, 0.0, start, has_stop, stop);
    const int status = library_.call("SetupExperiment", c_, 0, 0.0, start, has_stop ? 1 : 0, stop);
    return status <= fmi_warning ? std::max(status, simple("EnterInitializationMode")) : status;
  }
  int exit() { return simple("ExitInitializationMode"); }
  void start() {
    EXPECT_EQ(enter(), fmi_ok);
    EXPECT_EQ(exit(), fmi_ok);
  }
  int simple(const std::string& name) { return library_.call(name, c_); }

  int step(double from, double length) {
    if (library_.two()) return library_.call("DoStep", c_, from, length, 1);
    bool event = true, terminate = true, early = true;
    const int status = library_.call("DoStep", c_, from, length, true, &event, &terminate, &early, &last_);
    // Without an instance nothing is reported.
    EXPECT_TRUE(!c_ || !(event || terminate || early));
    return status;
  }
  double last() {
    if (library_.two()) {
      EXPECT_EQ(library_.call("GetRealStatus", c_, 2, &last_), fmi_ok);
    }
    return last_;
  }

  int get(std::vector<unsigned> references, double* values) {
    const unsigned* const of = references.data();
    if (library_.two()) return library_.call("GetReal", c_, of, references.size(), values);
    return library_.call("GetFloat64", c_, of, references.size(), values, references.size());
  }
  double get(unsigned reference) {
    double value = std::numeric_limits<double>::quiet_NaN();
    EXPECT_EQ(get({reference}, &value), fmi_ok);
    return value;
  }
  int count(unsigned reference) {
    int value = -1;
    const unsigned* const of = &reference;
    EXPECT_EQ(library_.two() ? library_.call("GetInteger", c_, of, std::size_t{1}, &value)
                             : library_.call("GetInt32", c_, of, std::size_t{1}, &value, std::size_t{1}),
              fmi_ok);
    return value;
  }
  int set(unsigned reference, double value) {
    const unsigned* const of = &reference;
    const double* const from = &value;
    if (library_.two()) return library_.call("SetReal", c_, of, std::size_t{1}, from);
    return library_.call("SetFloat64", c_, of, std::size_t{1}, from, std::size_t{1});
  }
  /// All outputs.
  std::vector<double> outputs() {
    std::vector<double> values;
    for (const FmuVariable& v : library_.fmu().variables)
      if (v.role == FmuVariable::Role::output) values.push_back(get(v.reference));
    return values;
  }

  /// How unknowns vary where knowns vary by the seed; `results`: of arrays, how many numbers these are.
  int vary(const std::vector<unsigned>& unknowns, const std::vector<unsigned>& knowns,
           const std::vector<double>& seed, double* result, std::size_t results = 0) {
    const unsigned *u = unknowns.data(), *k = knowns.data();
    const double* s = seed.data();
    if (library_.two())
      return library_.call("GetDirectionalDerivative", c_, u, unknowns.size(), k, knowns.size(), s, result);
    return library_.call("GetDirectionalDerivative", c_, u, unknowns.size(), k, knowns.size(), s, seed.size(),
                         result, results > 0 ? results : unknowns.size());
  }

  int get_state(void** state) {
    return library_.call(library_.two() ? "GetFMUstate" : "GetFMUState", c_, state);
  }
  int set_state(void* state) {
    return library_.call(library_.two() ? "SetFMUstate" : "SetFMUState", c_, state);
  }
  int free_state(void** state) {
    return library_.call(library_.two() ? "FreeFMUstate" : "FreeFMUState", c_, state);
  }
  std::size_t state_size(void* state) {
    std::size_t size = 0;
    EXPECT_EQ(
        library_.call(library_.two() ? "SerializedFMUstateSize" : "SerializedFMUStateSize", c_, state, &size),
        fmi_ok);
    return size;
  }
  int write_state(void* state, char* bytes, std::size_t size) {
    return library_.call(library_.two() ? "SerializeFMUstate" : "SerializeFMUState", c_, state, bytes, size);
  }
  int read_state(const char* bytes, std::size_t size, void** state) {
    return library_.call(library_.two() ? "DeSerializeFMUstate" : "DeserializeFMUState", c_, bytes, size,
                         state);
  }

 protected:
  const FmuLibrary& library() const { return library_; }

 private:
  static void log2(void* of, const char* name, int, const char* category, const char* message, ...) {
    EXPECT_TRUE(name && category);
    static_cast<FmuInstance*>(of)->messages_ += std::string(message) + "\n";
  }
  static void log3(void* of, int, const char*, const char* message) {
    static_cast<FmuInstance*>(of)->messages_ += std::string(message) + "\n";
  }

  const FmuLibrary& library_;
  FmuCallbacks callbacks_;
  std::string messages_;
  void* c_ = nullptr;
  double last_ = 0;
};

/// An instance for model exchange.
class ExchangeInstance : public FmuInstance {
 public:
  using FmuInstance::FmuInstance;

  struct Update {
    int status = fmi_error;
    bool changed = false, has_next = false;
    double next = 0;
  };
  Update update() {
    Update out;
    if (library().two()) {
      struct {
        int needed, terminate, nominals, values, has_next;
        double next;
      } info{1, 1, 1, 1, 1, 0};
      out.status = library().call("NewDiscreteStates", handle(), static_cast<void*>(&info));
      EXPECT_FALSE(info.needed || info.terminate);
      return {out.status, info.values != 0, info.has_next != 0, info.next};
    }
    bool needed = true, terminate = true, nominals = true;
    out.status = library().call("UpdateDiscreteStates", handle(), &needed, &terminate, &nominals,
                                &out.changed, &out.has_next, &out.next);
    EXPECT_FALSE(needed || terminate);
    return out;
  }
  /// Initialization and the first update.
  Update start_continuous() {
    start();
    const Update out = update();
    EXPECT_EQ(out.status, fmi_ok) << messages();
    EXPECT_EQ(simple("EnterContinuousTimeMode"), fmi_ok);
    return out;
  }
  Update event() {
    EXPECT_EQ(simple("EnterEventMode"), fmi_ok);
    const Update out = update();
    EXPECT_EQ(out.status, fmi_ok) << messages();
    EXPECT_EQ(simple("EnterContinuousTimeMode"), fmi_ok);
    return out;
  }

  int set_time(double time) { return library().call("SetTime", handle(), time); }
  int set_states(const std::vector<double>& x) { return set_states(x.data(), x.size()); }
  int set_states(const double* x, std::size_t count) {
    return library().call("SetContinuousStates", handle(), x, count);
  }
  int read(const std::string& function, double* to, std::size_t count) {
    return library().call(function, handle(), to, count);
  }
  std::vector<double> read(const std::string& function, std::size_t count) {
    std::vector<double> out(count);
    EXPECT_EQ(read(function, out.data(), count), fmi_ok) << messages();
    return out;
  }
  std::size_t size() const { return library().fmu().code.states.size(); }
  std::vector<double> states() { return read("GetContinuousStates", size()); }
  std::vector<double> nominals() { return read("GetNominalsOfContinuousStates", size()); }
  std::vector<double> indicators() {
    return read("GetEventIndicators", static_cast<std::size_t>(library().fmu().code.indicators));
  }
  std::string derivatives_function() const {
    return library().two() ? "GetDerivatives" : "GetContinuousStateDerivatives";
  }
  std::vector<double> derivatives() { return read(derivatives_function(), size()); }
  std::vector<double> derivatives(double time, const std::vector<double>& x) {
    EXPECT_EQ(set_time(time), fmi_ok);
    EXPECT_EQ(set_states(x), fmi_ok);
    return derivatives();
  }
};

}  // namespace mimbre::test
