#pragma once
#include "math/stress.h"
#include "mimbre/channels.h"
#include "mimbre/reduced_body.h"
#include "outputs/view.h"
#include "spec/check/checked_item.h"
#include "spec/output_kind.h"

/// At a node of a flexible body's surface, or the extreme of all. Of a rigid body they are 0, which is
/// allowed: a model may have a body in both ways.
namespace mimbre::outputs {

inline const spec::Body& body_of(const spec::Model& model, const spec::Output& o) {
  return model.bodies[static_cast<std::size_t>(o.item)];
}

/// `modes`: those of stress or strain. Their extreme: of the smallest principal value the smallest, of all
/// others the one of the largest magnitude.
template <class Value>
double at_surface(const Eigen::MatrixXd& modes, const OutputView& view, const spec::Output& o,
                  const Value& value) {
  const Eigen::Ref<const Eigen::VectorXd> y = view.amplitudes(o.item);
  const auto more_extreme = [&](double a, double b) {
    if (o.component == 6) return a > b;
    if (o.component == 7) return a < b;
    return std::abs(a) > std::abs(b);
  };
  if (o.node >= 0) return value(modes.middleRows<6>(6 * o.node) * y);
  double extreme = value(modes.topRows<6>() * y);
  for (Eigen::Index at = 6; at < modes.rows(); at += 6)
    if (const double here = value(modes.middleRows<6>(at) * y); more_extreme(here, extreme)) extreme = here;
  return extreme;
}

inline void check_surface(const checks::CheckedItem& item, const spec::Body& body, const spec::Output& o,
                          const char* what, Eigen::Index modes) {
  if (modes == 0)
    item.error(
        fmt::format("body '{}' has no {} modes; reduce its model again, with its elements", body.name, what));
  item.between("node", o.node, -1, static_cast<int>(body.flexible->nodes.cols()) - 1);
}

inline std::string describe_surface(const Compiled& m, const spec::Output& o, const std::string& what) {
  const spec::Body& body = body_of(m.spec(), o);
  std::string place = "largest";
  if (o.node >= 0 && body.flexible)
    place = body.flexible->node_labels.empty()
                ? fmt::format("point {}", o.node)
                : fmt::format("node {}", body.flexible->node_labels[static_cast<std::size_t>(o.node)]);
  return fmt::format("{} of '{}', {}", what, body.name, place);
}

struct Stress {
  static void check(const spec::Model& model, const checks::CheckedItem& item, const spec::Output& o) {
    if (item.finite("direction", o.direction) && !o.direction.isZero(0))
      item.error("a direction belongs to a strain, not to a stress");
    if (const auto& body = body_of(model, o); body.flexible)
      check_surface(item, body, o, "stress", body.flexible->stress.size());
  }
  static ChannelInfo describe(const Compiled& m, const spec::Output& o) {
    const char* const component = stress_components[static_cast<std::size_t>(o.component)];
    return {o.name, "Pa", describe_surface(m, o, fmt::format("stress {}", component))};
  }
  static double value(const OutputView& view, const spec::Output& o) {
    const spec::Body& body = body_of(view.spec(), o);
    if (!body.flexible) return 0;
    return at_surface(body.flexible->stress, view, o,
                      [&](const Vector6& here) { return stress_component(here, o.component); });
  }
  static constexpr OutputInfo info{.name = "stress",
                                   .of = OutputInfo::Of::body,
                                   .words = stress_components,
                                   .otherwise = von_mises_component,
                                   .place = OutputInfo::Place::surface,
                                   .check = check,
                                   .describe = describe,
                                   .value = value};
};

/// A component, or elongation along a direction in body axes.
struct Strain {
  static void check(const spec::Model& model, const checks::CheckedItem& item, const spec::Output& o) {
    item.finite("direction", o.direction);
    if (const auto& body = body_of(model, o); body.flexible)
      check_surface(item, body, o, "strain", body.flexible->strain.size());
  }
  static ChannelInfo describe(const Compiled& m, const spec::Output& o) {
    const char* const component = stress_components[static_cast<std::size_t>(o.component)];
    return {
        o.name, "1",
        describe_surface(m, o, o.direction.isZero(0) ? fmt::format("strain {}", component) : "elongation")};
  }
  static double value(const OutputView& view, const spec::Output& o) {
    const spec::Body& body = body_of(view.spec(), o);
    if (!body.flexible) return 0;
    return at_surface(body.flexible->strain, view, o, [&](const Vector6& here) {
      if (!o.direction.isZero(0)) return elongation(here, o.direction);
      return stress_component(o.component < 6 ? here : tensor_strain(here), o.component);
    });
  }
  static constexpr OutputInfo info{
      .name = "strain",
      .of = OutputInfo::Of::body,
      .words =
          OutputInfo::Words(stress_components).first(von_mises_component),  // that is a measure of stress
      .otherwise = max_principal_component,
      .place = OutputInfo::Place::surface,
      .along = true,
      .check = check,
      .describe = describe,
      .value = value};
};

}  // namespace mimbre::outputs
