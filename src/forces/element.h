#pragma once
#include <array>
#include <cmath>
#include <initializer_list>
#include <type_traits>

#include "compile/compiled.h"
#include "math/choice.h"
#include "math/function_values.h"
#include "math/rotation.h"
#include "spec/force_law.h"

namespace mimbre {

/// What an element is in an evaluation: places in the workspace, all of one element next to each other.
template <class T>
struct ElementState {
  int count;            ///< n components
  T *x, *v;             ///< n: measured, and its rate
  T* force;             ///< n: against the measure
  T* stiffness;         ///< n × n: ∂force/∂x, symmetric
  T* damping;           ///< n × n: ∂force/∂v, symmetric
  T *linear, *angular;  ///< n × 3: velocity and angular velocity of b against a → rate, global axes: the
                        ///< force on b is −Σ force · linear, its moment about b's origin −Σ force · angular
  T* surroundings;  ///< height of the road; a surface's two tangents, in its axes
  T* acceleration;  ///< ẍ, of what has inertia
  T* states;        ///< at the end of the step

  using Value = std::remove_const_t<T>;
  Vec3<Value> linear_of(int k) const { return {linear[3 * k], linear[3 * k + 1], linear[3 * k + 2]}; }
  Vec3<Value> angular_of(int k) const { return {angular[3 * k], angular[3 * k + 1], angular[3 * k + 2]}; }
  void set_linear(int k, const Vec3<Value>& a) const {
    for (int i = 0; i < 3; ++i) linear[3 * k + i] = a[i];
  }
  void set_angular(int k, const Vec3<Value>& a) const {
    for (int i = 0; i < 3; ++i) angular[3 * k + i] = a[i];
  }
};

template <class T>
ElementState<T> element_state_at(const ElementData& e, T* p) {
  const int n = e.count;
  const auto take = [&](int size) {
    T* taken = p;
    p += size;
    return taken;
  };
  ElementState<T> s;
  s.count = n;
  s.x = take(n);
  s.v = take(n);
  s.force = take(n);
  s.stiffness = take(n * n);
  s.damping = take(n * n);
  s.linear = take(3 * n);
  s.angular = take(3 * n);
  s.surroundings = take(surroundings_size(e.measure));
  s.acceleration = take(1);
  s.states = take(e.state_count);
  return s;
}
/// In the workspace's storage.
template <class T>
ElementState<T> element_state(const ElementData& e, T* storage) {
  return element_state_at(e, storage + e.storage);
}

/// Whether an element has tangents now: a contact far away has none.
template <class T>
bool acts(const ElementState<T>& s) {
  for (int k = 0; k < s.count * s.count; ++k)
    if (any(s.stiffness[k] != T(0)) || any(s.damping[k] != T(0))) return true;
  return false;
}

/// The model's numbers of laws; those of other scalars than double have to be given.
template <class T>
const T* numbers_of(const Compiled& model) {
  if constexpr (std::is_same_v<T, double>)
    return model.numbers.data();
  else
    return nullptr;
}

/// What a law may depend on besides what is measured.
template <class T>
struct LawContext {
  const Compiled& model;
  const ElementData& element;
  double time;
  const T* signals;  ///< all slots
  const T* states;   ///< of this element at the start of the step
  double step;       ///< s; 0: a position at rest, in which what relaxes has relaxed
  const T* all_numbers = numbers_of<T>(model);
  T holds = T(0);            ///< 1: what sticks as the step begins sticks (SignalValues::holds)
  const T* rates = nullptr;  ///< of all slots that time and inputs alone decide; null: time stands still

  const T* numbers() const { return all_numbers + element.numbers; }
  const FunctionData& function(int k) const { return model.functions[element.functions + k]; }
  const LawData* formula() const { return element.formula < 0 ? nullptr : &model.formulas[element.formula]; }
  /// Stands beside the image.
  const spec::UserLaw& user() const {
    return *model.spec().elements[static_cast<std::size_t>(element.spec)].user;
  }
  bool has_arguments() const { return element.argument_count > 0; }
  T argument(int k) const { return signals[model.arguments[element.arguments + k]]; }
  /// The argument's rate, 0 where time stands still. `otherwise`: where it is not known.
  T argument_rate(int k, const T& otherwise) const {
    using std::abs;
    const int slot = model.arguments[element.arguments + k];
    if (!rates) return T(0);
    if (slot >= model.signals.first_moving) return otherwise;
    return select(abs(rates[slot]) < T(1e300), rates[slot], otherwise);
  }
};

/// The energy of an element: what it stores, J, and those parts of its force against each component whose
/// work is not that of a potential. Over a step a part works by the mean of its values at both ends.
struct ElementEnergy {
  double stored = 0;
  double held =
      0;  ///< J of that, in internal states that `inner` bends: what of its work is not held is lost
  double lost = 0;   ///< J, that other internal states dissipated in the step
  double given = 0;  ///< J, that the step put in by what it says to the law
  double wound = 0;  ///< by which signals took up in the step what `dissipating` moves along: m
  double dissipating[6] = {}, working[6] = {}, inner[6] = {};
};

/// Arguments of a formula: `own` variables, then signals. Returns the array.
template <class T, std::size_t N>
void gather(const LawData& law, std::initializer_list<T> own, const T* signals, std::array<T, N>& out) {
  std::size_t at = 0;
  for (const T& x : own) out[at++] = x;
  for (const int slot : law.slots) out[at++] = signals[slot];
}

}  // namespace mimbre
