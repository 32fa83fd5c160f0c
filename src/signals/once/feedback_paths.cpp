#include "signals/once/feedback_paths.h"

namespace mimbre {
namespace {

/// Whether a sensor sees the coordinate or length that an element measures.
bool sees(const Compiled& m, const SensorData& sensor, const ElementData& of) {
  if (sensor.element < 0) return false;
  const ElementData& e = m.elements[sensor.element];
  if (e.measure != of.measure) return false;
  if (of.measure == Measure::coordinate) return e.joint_spec == of.joint_spec && e.local == of.local;
  return of.measure == Measure::distance && e.frame_a == of.frame_a && e.frame_b == of.frame_b;
}

template <class Use>
void for_arguments(const SignalsData& d, const SignalsData::Computed& f, const Use& use) {
  if (f.block < 0) {
    for (const int slot : f.law.slots) use(slot);
  } else {
    for (const LawData& law : d.blocks[f.block].laws)
      for (const int slot : law.slots) use(slot);
  }
}

/// Its last slot, and one more.
int end_of(const SignalsData& d, const SignalsData::Computed& f) {
  return f.slot + (f.block < 0 ? 1 : d.blocks[f.block].outputs);
}

FeedbackPath feedback_path(const Compiled& m, const ElementData& of) {
  const SignalsData& d = m.signals;
  FeedbackPath path;
  const std::vector<char> none(static_cast<std::size_t>(d.slots), 0);
  std::vector<char> goes = none;  // by the element's motion
  const auto flag = [](std::vector<char>& flags, int slot) -> char& {
    return flags[static_cast<std::size_t>(slot)];
  };
  for (const SignalsData::Sensor& sensor : d.sensors) {
    const SensorData& s = m.sensors[sensor.sensor];
    if (!sees(m, s, of)) continue;
    path.own.push_back({sensor.slot, s.is_rate});
    flag(goes, sensor.slot) = 1;
  }
  std::vector<char> depends;
  for (const SignalsData::Computed& f : d.moving) {
    bool any = false;
    for_arguments(d, f, [&](int slot) { any = any || flag(goes, slot); });
    depends.push_back(any);
    for (int slot = f.slot; any && slot < end_of(d, f); ++slot) flag(goes, slot) = 1;
  }
  path.closed = flag(goes, of.feedback);
  std::vector<char> needed = none, taken(d.moving.size(), 0);
  flag(needed, of.feedback) = 1;
  for (std::size_t k = d.moving.size(); k-- > 0;) {
    const SignalsData::Computed& f = d.moving[k];
    for (int slot = f.slot; depends[k] && slot < end_of(d, f); ++slot) taken[k] |= flag(needed, slot);
    if (taken[k]) for_arguments(d, f, [&](int slot) { flag(needed, slot) = 1; });
  }
  std::vector<char> known = none;
  for (const FeedbackPath::Own& own : path.own) flag(known, own.slot) = 1;
  for (std::size_t k = 0; k < d.moving.size(); ++k) {
    if (!taken[k]) continue;
    const SignalsData::Computed& f = d.moving[k];
    path.computed.push_back(static_cast<int>(k));
    for_arguments(d, f, [&](int slot) {
      if (slot < d.first_moving || flag(known, slot)) return;
      path.given.push_back(slot);
      flag(known, slot) = 1;
    });
    for (int slot = f.slot; slot < end_of(d, f); ++slot) flag(known, slot) = 1;
  }
  return path;
}

}  // namespace

std::vector<FeedbackPath> feedback_paths(const Compiled& m) {
  std::vector<FeedbackPath> paths(m.elements.size());
  for (std::size_t k = 0; k < m.elements.size(); ++k)
    if (m.elements[k].feedback >= 0) paths[k] = feedback_path(m, m.elements[k]);
  return paths;
}

}  // namespace mimbre
