#include "simulation/state/fingerprint.h"

#include "base/hash64.h"
#include "compile/image.h"
#include "mimbre/outside_block.h"
#include "mimbre/run_option.h"

namespace mimbre {

std::uint64_t fingerprint(const Model& model, const Method& method,
                          const std::vector<ChannelInfo>& channels) {
  Hash64 hash;
  hash.add(model.spec().text);
  for (const ChannelInfo& channel : channels)
    hash.add(channel.name + '\n' + channel.unit + '\n' + channel.meaning);
  hash.add(model.image().hash());
  for (const spec::Block& block : model.spec().blocks)
    if (block.outside) hash.add(block.outside->identity());
  for (const spec::Event& event : model.spec().events) hash.add(event.name);
  for (const RunOption& option : run_option_table())
    if (option.changes_states) hash.add(value_in(option, method));
  for (const bool watched : {method.energies, method.validity, method.warnings})
    hash.add(static_cast<double>(watched));
  return hash.value() != 0 ? hash.value() : 1;
}

}  // namespace mimbre
