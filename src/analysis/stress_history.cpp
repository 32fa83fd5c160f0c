#include "mimbre/stress_history.h"

#include <algorithm>
#include <numeric>

namespace mimbre {

using Eigen::Index;

StressHistory stress_history(const BodyDrawing& body, const Eigen::VectorXd& time,
                             const Eigen::Ref<const Eigen::MatrixXd>& amplitudes, int most, double apart) {
  const Index points = body.points.cols(), modes = body.stress.cols();
  StressHistory out;
  out.envelope = Eigen::VectorXd::Zero(points);
  std::vector<Index> when(static_cast<std::size_t>(points), 0);
  // A block of instants at a time: products of matrices, within a bounded memory.
  const Index block = std::clamp<Index>(4'000'000 / std::max<Index>(6 * points, 1), 1, 64);
  Eigen::MatrixXd stress;
  for (Index begin = 0; begin < time.size(); begin += block) {
    const Index count = std::min(block, time.size() - begin);
    stress.noalias() = body.stress * amplitudes.block(begin, 0, count, modes).transpose();
    for (Index k = 0; k < count; ++k)
      for (Index p = 0; p < points; ++p) {
        const double value = von_mises(stress.col(k).segment<6>(6 * p));
        if (value > out.envelope[p]) {
          out.envelope[p] = value;
          when[static_cast<std::size_t>(p)] = begin + k;
        }
      }
  }
  std::vector<Index> order(static_cast<std::size_t>(points));
  std::iota(order.begin(), order.end(), Index{0});
  std::stable_sort(order.begin(), order.end(),
                   [&](Index a, Index b) { return out.envelope[a] > out.envelope[b]; });
  for (const Index p : order) {
    if (static_cast<int>(out.spots.size()) >= most || !(out.envelope[p] > 0)) break;
    const bool near = std::any_of(out.spots.begin(), out.spots.end(), [&](const HotSpot& s) {
      return (body.points.col(s.node) - body.points.col(p)).norm() < apart;
    });
    if (near) continue;
    const Index k = when[static_cast<std::size_t>(p)];
    out.spots.push_back({static_cast<int>(p), out.envelope[p], time[k],
                         body.stress.middleRows<6>(6 * p) * amplitudes.row(k).head(modes).transpose()});
  }
  return out;
}

}  // namespace mimbre
