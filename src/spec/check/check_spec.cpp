#include "spec/check/check_spec.h"

#include <unordered_set>

#include "spec/check/checked_item.h"

namespace mimbre {
namespace checks {
namespace {

template <class Items>
void check_names_of(const char* kind, const Items& items, std::vector<Diagnostic>& errors) {
  std::unordered_set<std::string> taken;
  for (std::size_t k = 0; k < items.size(); ++k) {
    const CheckedItem item(errors, kind, items[k].name, items[k].mark, k);
    if (items[k].name.empty())
      item.error("has no name; messages, channels and pictures need one");
    else if (!taken.insert(items[k].name).second)
      item.error(fmt::format("another {} has this name; rename one", kind));
  }
}

}  // namespace

void CheckedItem::pose(const spec::Pose& pose) const {
  finite("position", pose.position);
  if (!finite("rotation", pose.rotation)) return;
  const Eigen::Matrix3d& R = pose.rotation;
  const double off = (R.transpose() * R - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff();
  if (off > 1e-6)
    error(
        fmt::format("rotation is no rotation: its columns must be unit vectors at right angles, and miss "
                    "that by {:.2g}",
                    off));
  else if (!(R.determinant() > 0))
    error("rotation is left-handed; the third column must be the first cross the second");
}

void check_names(const spec::Model& model, std::vector<Diagnostic>& errors) {
  check_names_of("body", model.bodies, errors);
  check_names_of("frame", model.frames, errors);
  check_names_of("joint", model.joints, errors);
  check_names_of("spring", model.springs, errors);
  check_names_of("load", model.loads, errors);
  check_names_of("road", model.roads, errors);
  check_names_of("tyre", model.tyres, errors);
  check_names_of("element", model.elements, errors);
  check_names_of("constraint", model.constraints, errors);
  check_names_of("surface", model.surfaces, errors);
  check_names_of("contact", model.contacts, errors);
  check_names_of("input", model.inputs, errors);
  check_names_of("signal", model.signals, errors);
  check_names_of("event", model.events, errors);
  check_names_of("output", model.outputs, errors);
}

}  // namespace checks

void check_spec(const spec::Model& model) {
  using namespace checks;
  std::vector<Diagnostic> errors;
  if (model.bodies.empty()) errors.push_back({{model.file, 0, 0}, "the model has no body; add one"});
  for (const auto check :
       {check_names, check_bodies, check_frames, check_joints, check_springs, check_loads, check_roads,
        check_tyres, check_inputs, check_signals, check_blocks, check_events, check_elements,
        check_constraints, check_surfaces, check_contacts, check_outputs, check_simulation})
    check(model, errors);
  if (errors.empty()) return;
  constexpr std::size_t most = 100;
  if (errors.size() > most) {
    errors.resize(most);
    errors.push_back({{}, "too many errors; the rest is not shown"});
  }
  throw InputError(std::move(errors));
}

}  // namespace mimbre
