#include "live/exchanged.h"

#include <fmt/format.h>

#include <algorithm>

#include "base/hash64.h"
#include "mimbre/diagnostics.h"
#include "mimbre/exchange_layout.h"

namespace mimbre::live {

Exchanged::Exchanged(const Simulation& simulation, const ExchangeOptions& options) {
  const auto& channels = simulation.channels();
  if (options.outputs.empty())
    for (int k = 0; k < simulation.output_count(); ++k) channels_.push_back({k});
  for (const std::string& name : options.outputs) channels_.push_back(simulation.channel(name));
  const auto& inputs = simulation.inputs();
  if (options.inputs.empty())
    for (std::size_t k = 0; k < inputs.size(); ++k)
      if (!inputs[k].tunable) inputs_.push_back(static_cast<int>(k));
  for (const std::string& name : options.inputs) inputs_.push_back(simulation.input(name));
  for (const std::size_t count : {channels_.size(), inputs_.size()})
    if (count > MIMBRE_EXCHANGE_MOST)
      throw InputError(Mark{}, fmt::format("{} values are to be exchanged; there may be {} in each direction",
                                           count, MIMBRE_EXCHANGE_MOST));
  names_ = fmt::format("outputs {}\n", channels_.size());
  for (const Simulation::Channel channel : channels_) {
    const ChannelInfo& info = channels[static_cast<std::size_t>(channel.index)];
    names_ += info.name + '\t' + info.unit + '\n';
  }
  names_ += fmt::format("inputs {}\n", inputs_.size());
  for (const int input : inputs_) {
    const spec::Input& info = inputs[static_cast<std::size_t>(input)];
    names_ += info.name + '\t' + info.unit + '\n';
  }
  Hash64 hash;
  hash.add(names_);
  layout_ = std::max<std::uint64_t>(hash.value(), 1);
}

void Exchanged::read(Simulation& simulation, double* values) const {
  for (std::size_t k = 0; k < channels_.size(); ++k) values[k] = simulation.value(channels_[k]);
}

void Exchanged::write(Simulation& simulation, const double* values) const {
  for (std::size_t k = 0; k < inputs_.size(); ++k)
    if (std::isfinite(values[k]) && simulation.input_value(inputs_[k]) != values[k])
      simulation.set_input(inputs_[k], values[k]);
}

}  // namespace mimbre::live
