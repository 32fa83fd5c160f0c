#pragma once
#include <cstddef>
#include <cstdint>

/// The functions of an FMU that are called, as the standards declare them: Functional Mock-up
/// Interface 2.0.4, 2.2 and 4.2; 3.0.1, 2.2, 2.3 and 4.2 (https://fmi-standard.org). Co-simulation only.
namespace mimbre::fmu {

using Reference = std::uint32_t;
/// The same numbers in both versions; FMI 2 has `pending` = 5 besides.
struct Status {
  enum : int { ok, warning, discard, error, fatal, pending };
};

namespace fmi2 {

using Logger = void (*)(void* environment, const char* instance, int status, const char* category,
                        const char* message, ...);
struct Callbacks {
  Logger log;
  void* (*allocate)(std::size_t count, std::size_t size);
  void (*release)(void* memory);
  void (*step_finished)(void* environment, int status);
  void* environment;
};
using GetText = const char* (*)();
using Instantiate = void* (*)(const char* name, int type, const char* guid, const char* resources,
                              const Callbacks* callbacks, int visible, int logging);
using Free = void (*)(void*);
using SetupExperiment = int (*)(void*, int tolerance_defined, double tolerance, double start,
                                int stop_defined, double stop);
using Simple = int (*)(void*);
using DoStep = int (*)(void*, double time, double step, int no_earlier_state);
template <class T>
using Get = int (*)(void*, const Reference*, std::size_t, T*);
template <class T>
using Set = int (*)(void*, const Reference*, std::size_t, const T*);

}  // namespace fmi2

namespace fmi3 {

using Logger = void (*)(void* environment, int status, const char* category, const char* message);
using Instantiate = void* (*)(const char* name, const char* token, const char* resources, bool visible,
                              bool logging, bool event_mode, bool early_return, const Reference* required,
                              std::size_t required_count, void* environment, Logger log,
                              void* intermediate_update);
using EnterInitialization = int (*)(void*, bool tolerance_defined, double tolerance, double start,
                                    bool stop_defined, double stop);
using DoStep = int (*)(void*, double time, double step, bool no_earlier_state, bool* event, bool* terminate,
                       bool* early, double* last_time);
template <class T>
using Get = int (*)(void*, const Reference*, std::size_t, T*, std::size_t);
template <class T>
using Set = int (*)(void*, const Reference*, std::size_t, const T*, std::size_t);

}  // namespace fmi3

// States, the same in both versions.
using GetState = int (*)(void*, void** state);
using SetState = int (*)(void*, void* state);
using FreeState = int (*)(void*, void** state);
using SerializedSize = int (*)(void*, void* state, std::size_t* size);
using Serialize = int (*)(void*, void* state, std::uint8_t* bytes, std::size_t size);
using Deserialize = int (*)(void*, const std::uint8_t* bytes, std::size_t size, void** state);

}  // namespace mimbre::fmu
