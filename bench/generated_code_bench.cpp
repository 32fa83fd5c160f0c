#include <benchmark/benchmark.h>
#include <dlfcn.h>
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include "mimbre/generate.h"
#include "mimbre/model_file.h"
#include "mimbre/simulation.h"

/// Steps of generated code beside those of the library: docs/generated-code.md. From the folder of the
/// project; compilers' options by CFLAGS.
namespace {

constexpr std::array models{"tutorial/pendulum",         "pendulum/flexible",   "double-four-bar/mechanism",
                            "bricard/mechanism",         "tutorial/four-bar",   "crank-train/model",
                            "slider-crank/slider-crank", "wind-turbine/model",  "washing-machine/model",
                            "iltis/suspension",          "iltis/vehicle",       "iltis/drive",
                            "iltis/anti-lock",           "iltis/brake-in-bend", "solar-array/model"};
constexpr double seconds = 1;

mimbre::RunOptions fixed_cost() {
  mimbre::RunOptions options;
  options.fixed_cost = true;
  options.energies = options.validity = options.warnings = false;
  return options;
}

/// A model, and its code compiled and loaded.
struct Pair {
  explicit Pair(const std::string& path) {
    model = mimbre::Model::compile(mimbre::load_model("examples/" + path + ".yaml", {}));
    simulation = std::make_unique<mimbre::Simulation>(model, fixed_cost());
    start = simulation->save();
    steps = static_cast<int>(std::lround(seconds / simulation->step_size()));
    const mimbre::GeneratedCode code = mimbre::generate_code(model, {}, "code");
    const std::string folder =
        (std::filesystem::temp_directory_path() / fmt::format("mimbre_generated_code_{}", getpid())).string();
    mimbre::write_code(code, folder);
    const char* flags = std::getenv("CFLAGS");
    // One name for each: the loader knows what it has loaded by its name.
    const std::string library = fmt::format("{}/{}.so", folder, std::hash<std::string>()(path));
    const auto begin = std::chrono::steady_clock::now();
    if (std::system(fmt::format("cc -std=c99 {0} -fPIC -shared {1}/code.c -o {2} -lm", flags ? flags : "-O2",
                                folder, library)
                        .c_str()) != 0)
      throw std::runtime_error("the code of " + path + " could not be compiled");
    compile_seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    kib = static_cast<double>(std::filesystem::file_size(library)) / 1024;
    struct_kib = static_cast<double>(code.bytes) / 1024;
    void* const loaded = dlopen(library.c_str(), RTLD_NOW | RTLD_LOCAL);
    std::filesystem::remove_all(folder);
    if (!loaded) throw std::runtime_error(dlerror());
    init = reinterpret_cast<void (*)(void*)>(dlsym(loaded, "code_init"));
    step = reinterpret_cast<int (*)(void*)>(dlsym(loaded, "code_step"));
    get_output = reinterpret_cast<double (*)(void*, int)>(dlsym(loaded, "code_get_output"));
    state.resize(static_cast<std::size_t>(code.bytes) / 8 + 1);
    find_difference(code);
  }

  /// The largest of an output, by its largest value or 1.
  void find_difference(const mimbre::GeneratedCode& code) {
    std::vector<mimbre::Simulation::Channel> channels;
    for (const mimbre::GeneratedVariable& output : code.outputs) {
      std::string name = "signal." + output.name;
      for (const mimbre::ChannelInfo& channel : simulation->channels())
        if (channel.name == output.name) name = output.name;
      channels.push_back(simulation->channel(name));
    }
    std::vector<double> off(channels.size(), 0), size(channels.size(), 1);
    init(state.data());
    for (int k = 0; k <= steps; ++k) {
      for (std::size_t i = 0; i < channels.size(); ++i) {
        const double expected = simulation->value(channels[i]);
        off[i] = std::max(off[i], std::abs(get_output(state.data(), static_cast<int>(i)) - expected));
        size[i] = std::max(size[i], std::abs(expected));
      }
      simulation->step();
      step(state.data());
    }
    for (std::size_t i = 0; i < off.size(); ++i) difference = std::max(difference, off[i] / size[i]);
  }

  std::shared_ptr<const mimbre::Model> model;
  std::unique_ptr<mimbre::Simulation> simulation;
  mimbre::Simulation::Snapshot start;
  int steps = 0;
  double compile_seconds = 0, kib = 0, struct_kib = 0, difference = 0;
  void (*init)(void*) = nullptr;
  int (*step)(void*) = nullptr;
  double (*get_output)(void*, int) = nullptr;
  std::vector<double> state;
};

Pair& pair_of(const std::string& path) {
  static std::map<std::string, Pair> made;
  return made.try_emplace(path, path).first->second;
}

void count(benchmark::State& state, const Pair& pair) {
  state.counters["step"] = benchmark::Counter(static_cast<double>(state.iterations() * pair.steps),
                                              benchmark::Counter::kIsRate | benchmark::Counter::kInvert);
}

const bool registered = [] {
  for (const std::string path : models) {
    benchmark::RegisterBenchmark(("library/" + path).c_str(), [path](benchmark::State& state) {
      Pair& pair = pair_of(path);
      for (auto _ : state) {
        pair.simulation->restore(pair.start);
        for (int k = 0; k < pair.steps; ++k) benchmark::DoNotOptimize(pair.simulation->step());
      }
      count(state, pair);
    });
    benchmark::RegisterBenchmark(("code/" + path).c_str(), [path](benchmark::State& state) {
      Pair& pair = pair_of(path);
      for (auto _ : state) {
        pair.init(pair.state.data());
        for (int k = 0; k < pair.steps; ++k) benchmark::DoNotOptimize(pair.step(pair.state.data()));
      }
      count(state, pair);
      state.counters["difference"] = pair.difference;
      state.counters["KiB"] = pair.kib;
      state.counters["struct_KiB"] = pair.struct_kib;
      state.counters["compile_s"] = pair.compile_seconds;
    });
  }
  return true;
}();

}  // namespace
