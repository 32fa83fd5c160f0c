#include "simulation/state/fingerprint.h"

#include "base/hash64.h"
#include "compile/image.h"

namespace mimbre {

std::uint64_t fingerprint(const Model& model, const Method& method,
                          const std::vector<ChannelInfo>& channels) {
  Hash64 hash;
  hash.add(model.spec().text);
  for (const ChannelInfo& channel : channels)
    hash.add(channel.name + '\n' + channel.unit + '\n' + channel.meaning);
  hash.add(model.image().hash());
  for (const spec::Event& event : model.spec().events) hash.add(event.name);
  for (const double choice :
       {static_cast<double>(method.formulation), static_cast<double>(method.inertia),
        static_cast<double>(method.formalism), static_cast<double>(method.integrator), method.step,
        method.rho, method.xi, method.tolerance, method.penalty, static_cast<double>(method.max_iterations),
        static_cast<double>(method.substeps), static_cast<double>(method.fixed_cost),
        static_cast<double>(method.energies), static_cast<double>(method.validity),
        static_cast<double>(method.warnings)})
    hash.add(choice);
  if (method.accuracy > 0) hash.add(method.accuracy);
  return hash.value() != 0 ? hash.value() : 1;
}

}  // namespace mimbre
