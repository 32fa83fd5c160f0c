#include <benchmark/benchmark.h>

#include <cmath>
#include <vector>

#include "support/elementary_error.h"

/// Speed of the elementary functions beside those of the C library, and their largest error over a million
/// random arguments: mimbre_bench --benchmark_filter=elementary
namespace {

using mimbre::test::Tried;
using mimbre::test::TriedPair;

struct Timed {
  const char* name;
  double (*own)(double);
  double (*standard)(double);
  double low, high;
};
const Timed timed[] = {
    {"sin", mimbre::sin, std::sin, -3, 3},       {"cos", mimbre::cos, std::cos, -3, 3},
    {"atan", mimbre::atan, std::atan, -3, 3},    {"exp", mimbre::exp, std::exp, -3, 3},
    {"expm1", mimbre::expm1, std::expm1, -3, 3}, {"log", mimbre::log, std::log, 0.1, 10},
    {"tanh", mimbre::tanh, std::tanh, -3, 3},
};
struct TimedPair {
  const char* name;
  double (*own)(double, double);
  double (*standard)(double, double);
};
const TimedPair timed_pairs[] = {{"atan2", mimbre::atan2, std::atan2},
                                 {"pow", mimbre::pow, std::pow},
                                 {"hypot", mimbre::hypot, std::hypot}};

std::vector<double> numbers(double low, double high, unsigned seed) {
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> within(low, high);
  std::vector<double> x(1024);
  for (double& number : x) number = within(random);
  return x;
}

void run(benchmark::State& state, double (*f)(double), double low, double high) {
  const std::vector<double> x = numbers(low, high, 1);
  std::size_t k = 0;
  for (auto _ : state) benchmark::DoNotOptimize(f(x[k++ % x.size()]));
}
void run_pair(benchmark::State& state, double (*f)(double, double)) {
  const std::vector<double> x = numbers(0.1, 3, 1), y = numbers(-3, 3, 2);
  std::size_t k = 0;
  for (auto _ : state) {
    benchmark::DoNotOptimize(f(x[k % x.size()], y[k % x.size()]));
    ++k;
  }
}

template <class F>
void error(benchmark::State& state, const F& f) {
  for (auto _ : state) state.counters["ulp"] = mimbre::test::largest_error(f, 1'000'000);
}

const bool registered = [] {
  using benchmark::RegisterBenchmark;
  const auto named = [](const char* kind, const std::string& name) {
    return "elementary/" + name + "/" + kind;
  };
  for (const Timed& f : timed) {
    RegisterBenchmark(named("own", f.name).c_str(), run, f.own, f.low, f.high);
    RegisterBenchmark(named("library", f.name).c_str(), run, f.standard, f.low, f.high);
  }
  for (const TimedPair& f : timed_pairs) {
    RegisterBenchmark(named("own", f.name).c_str(), run_pair, f.own);
    RegisterBenchmark(named("library", f.name).c_str(), run_pair, f.standard);
  }
  for (const Tried& f : mimbre::test::tried())
    RegisterBenchmark(named("error", f.name).c_str(), error<Tried>, f)->Iterations(1);
  for (const TriedPair& f : mimbre::test::tried_pairs())
    RegisterBenchmark(named("error", f.name).c_str(), error<TriedPair>, f)->Iterations(1);
  return true;
}();

}  // namespace
