#include "app/advice.h"

#include <fmt/format.h>

#include <cstdio>

#include "mimbre/slow_formulation.h"

namespace mimbre::app {

void print_advice(const Simulation& simulation) {
  const std::string advice = explain_slow_formulation(simulation);
  if (!advice.empty()) fmt::print(stderr, "mimbre: note: {}\n", advice);
}

}  // namespace mimbre::app
