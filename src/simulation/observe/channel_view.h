#pragma once
#include <vector>

#include "dynamics/relative/system.h"
#include "dynamics/state.h"
#include "outputs/view.h"
#include "simulation/observe/joint_channels.h"
#include "spec/output_kind.h"

namespace mimbre {

/// An output of a spec, with what is looked up once.
struct ObservedOutput {
  const spec::Output* output;
  const OutputInfo* info;
  std::vector<int> bodies;  ///< of the tree, of which the motion of mass is seen

  ObservedOutput(const Compiled& model, const spec::Output& output);
};

/// What an output sees of a system whose last evaluation is of that state. Its scratch is used.
class ChannelView final : public OutputView {
 public:
  ChannelView(const JointObserver& joints, const std::vector<int>& bodies, relative::RelativeSystem& system,
              const State& state)
      : OutputView(system.model(), state.q),
        joints_(joints),
        bodies_(bodies),
        system_(system),
        state_(state) {}

  Vec3d origin() const override;
  Motion<double> motion(int frame) const override;
  Vec3d deflection(int frame) const override;
  JointCoordinates coordinates(int joint) const override;
  MassMotion mass_motion() const override;
  ElementState<const double> element(int element) const override;
  ContactSum contact(int contact, int body) const override;
  double slot(int slot) const override;
  JointReaction reaction(int joint) const override;
  Eigen::Matrix<double, 6, 1> section_forces(int body, int section) const override;

 private:
  const JointObserver& joints_;
  const std::vector<int>& bodies_;
  relative::RelativeSystem& system_;
  const State& state_;
};

}  // namespace mimbre
