#include "simulation/fingerprint.h"

#include <cmath>
#include <random>

#include "base/hash64.h"
#include "dynamics/relative/system.h"
#include "joints/table.h"

namespace mimbre {
namespace {

constexpr int states = 8;
constexpr double digits = 1e5;

/// Numbers relative to the largest of them.
void add_rounded(Hash64& hash, const Eigen::VectorXd& x) {
  const double largest = x.size() > 0 ? x.cwiseAbs().maxCoeff() : 0;
  const double unit = largest > 0 && std::isfinite(largest) ? std::exp2(std::ilogb(largest)) / digits : 1;
  for (const double value : x) hash.add(std::isfinite(value) ? std::round(value / unit) * unit : 0.0);
}

/// What the model does says what it is: masses, shapes, laws, loads over time.
void add_forces(Hash64& hash, const Compiled& m, spec::Simulation::Inertia inertia) {
  relative::RelativeSystem system(m, inertia);
  const std::vector<double>& scale = system.scales().coordinates;
  std::mt19937 engine(1);
  const auto random = [&](double size) { return size * (2 * (engine() / 4294967295.0) - 1); };
  Eigen::VectorXd start = Eigen::VectorXd::Zero(m.positions), q(m.positions), x(m.velocities), v = x, a = x,
                  multipliers(m.equations), r(m.velocities);
  for (const BodyData& b : m.bodies)
    if (const int at = joint_info(b.joint).quaternion; at >= 0) start[b.q + at] = 1;
  for (int state = 0; state < states; ++state) {
    for (int k = 0; k < m.velocities; ++k) {
      x[k] = random(0.3) * scale[static_cast<std::size_t>(k)];
      v[k] = random(1) * scale[static_cast<std::size_t>(k)];
      a[k] = random(10) * scale[static_cast<std::size_t>(k)];
    }
    for (double& multiplier : multipliers) multiplier = random(m.mass_scale);
    const double time = state * m.spec().simulation.end / states;
    system.retract(start.data(), x.data(), q.data());
    system.begin_step(q.data());
    system.residual(time, q.data(), v.data(), a.data(), multipliers.data(), 0, r.data());
    add_rounded(hash, r);
    for (const double* phi : {system.phi(), system.phi_dot(), system.phi_ddot()})
      add_rounded(hash, Eigen::Map<const Eigen::VectorXd>(phi, m.equations));
  }
}

}  // namespace

std::uint64_t fingerprint(const Compiled& m, const Method& method, const std::vector<ChannelInfo>& channels) {
  Hash64 hash;
  hash.add(m.spec().text);
  for (const ChannelInfo& channel : channels)
    hash.add(channel.name + '\n' + channel.unit + '\n' + channel.meaning);
  for (const int size : {m.positions, m.velocities, m.equations}) hash.add(static_cast<double>(size));
  add_forces(hash, m, method.inertia);
  for (const spec::Event& event : m.spec().events) hash.add(event.name);
  for (const double number : m.signals.numbers) hash.add(number);
  for (const double choice :
       {static_cast<double>(method.formulation), static_cast<double>(method.inertia),
        static_cast<double>(method.formalism), static_cast<double>(method.integrator), method.step,
        method.rho, method.xi, method.tolerance, method.penalty, static_cast<double>(method.max_iterations),
        static_cast<double>(method.substeps), static_cast<double>(method.fixed_cost),
        static_cast<double>(method.energies), static_cast<double>(method.validity),
        static_cast<double>(method.warnings)})
    hash.add(choice);
  return hash.value() != 0 ? hash.value() : 1;
}

}  // namespace mimbre
