#pragma once
#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

#include "mimbre/exchange.h"

namespace mimbre::live {

/// The numbers that a loop and another program hand each other, in their order, and their names.
class Exchanged {
 public:
  Exchanged(const Simulation& simulation, const ExchangeOptions& options);

  /// "outputs N", a line of name, tab and unit for each, "inputs M", and such lines.
  const std::string& names() const { return names_; }
  /// A hash of the names, never 0.
  std::uint64_t layout() const { return layout_; }
  std::size_t output_count() const { return channels_.size(); }
  std::size_t input_count() const { return inputs_.size(); }

  /// Channels of the simulation now.
  void read(Simulation& simulation, double* values) const;
  /// Inputs for the steps that follow; what is not finite stays as it is.
  void write(Simulation& simulation, const double* values) const;

 private:
  std::vector<Simulation::Channel> channels_;
  std::vector<int> inputs_;
  std::string names_;
  std::uint64_t layout_ = 0;
};

}  // namespace mimbre::live
