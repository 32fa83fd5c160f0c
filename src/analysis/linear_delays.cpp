#include <fmt/format.h>

#include <cmath>

#include "analysis/linear_point.h"
#include "compile/compiled.h"

namespace mimbre::linear {
namespace {

/// Padé's approximation of exp(−s τ) of degrees m over n, coefficients of the highest power first:
///   Σ_k (m + n − k)! d! / ((m + n)! k! (d − k)!) (∓ s τ)^k,  d = m above and n below.
Eigen::RowVectorXd pade_polynomial(int degree, int all, double tau) {
  Eigen::RowVectorXd c(degree + 1);
  double factor = 1;
  for (int k = 0; k <= degree; ++k) {
    c[degree - k] = factor;
    factor *= tau * (degree - k) / ((all - k) * (k + 1.0));
  }
  return c;
}

}  // namespace

std::shared_ptr<const Model> without_delays(std::shared_ptr<const Model> model, int order,
                                            std::vector<std::string>& notes) {
  const auto is_delay = [](const spec::Block& b) { return b.type == "delay" && !(b.every > 0); };
  bool any = false;
  for (const spec::Block& b : model->spec().blocks) any = any || is_delay(b);
  if (!any) return model;
  spec::Model changed = model->spec();
  for (spec::Block& b : changed.blocks) {
    if (!is_delay(b)) continue;
    const double tau = b.numbers.at(0);
    b.type = "transfer_function";
    b.numbers.clear();
    // Strictly proper, as the delay passes on nothing at once.
    b.matrices = {pade_polynomial(order - 1, 2 * order - 1, -tau),
                  pade_polynomial(order, 2 * order - 1, tau)};
    notes.push_back(fmt::format("the delay '{}' of {} s is Padé's approximation of degrees {} over {}",
                                b.name, tau, order - 1, order));
  }
  return Model::compile(std::move(changed));
}

}  // namespace mimbre::linear
