#pragma once
#include <algorithm>
#include <cmath>
#include <limits>

#include "simulation/step/events.h"
#include "simulation/step/mechanism.h"
#include "simulation/step/step_maker.h"

namespace mimbre {

/// How closely the time of an event is found, and the shortest part of a step, s: a share of the step, and at
/// a late time no less than its round-off.
constexpr double event_resolution(double step, double time) {
  return std::max(1e-7 * step, 4 * std::numeric_limits<double>::epsilon() * time);
}

/// How often at one moment events make others happen, and relays make others switch.
constexpr int longest_chain = 8;

/// Makes a step in which events may happen: where one does, a part of the step ends there, and what follows
/// from it acts from there on. Whether one happened shows at the end of a part, by the side of zero that its
/// value is on then. When, is found by making that part again, shorter, until the crossing is known to
/// event_resolution(): regula falsi with the Illinois rule (Dowell, Jarratt, BIT 11, 1971) on the
/// integrator's own solution, not on an interpolation of it. Events in so many parts that a step should not
/// have them happen at its end. With a fixed cost all happen at the end of the step in which they cross.
///
/// The host makes the state visible: `see()` evaluates it for the events; `look_anew()`, it is another one;
/// `take_jumps()`, inputs have been set; `watch()`, a part is accepted; `move_time(t)`, the state counts as
/// that at t. Allocates nothing.
template <class Host>
class EventStep {
 public:
  EventStep(Host& host, Events& events, Mechanism& mechanism, StepMaker& steps, double step)
      : host_(host),
        events_(events),
        mechanism_(mechanism),
        steps_(steps),
        step_(step),
        resolution_(event_resolution(step, mechanism.state.time)) {}

  /// One step of this length, and what has happened by its end.
  StepReport whole(double length) {
    if (settle() || !make(length)) return report_;
    host_.watch();
    settle();
    return report_;
  }

  /// To `end`, or to where one stops the run.
  StepReport to(double end) {
    constexpr int most_parts = 32;
    for (int part = 0; part < most_parts; ++part) {
      // What host, signals or other events have set may have made values jump.
      if (settle()) return report_;
      events_.keep(Events::End::before);
      const double from = mechanism_.state.time, length = end - from;
      if (!(length > resolution_)) break;
      if (!make(length)) return report_;
      if (part + 1 < most_parts && !find_events(length)) return report_;
      host_.watch();
      if (settle()) return report_;
      if (end - mechanism_.state.time <= resolution_) break;
    }
    // The step's parts may end beside `end` by round-off; the state there has been shown already.
    host_.move_time(end);
    return report_;
  }

  bool stopped() const { return stopped_; }

 private:
  bool look() {
    return host_.see([&](auto&... seen) { return events_.look(seen...); });
  }

  /// Lets happen what has crossed, and what that makes cross at the same moment. True where it stops the run.
  bool settle() {
    host_.take_jumps();
    host_.see([&](auto&, auto& system, auto&) { events_.see_relays(system); });
    for (int k = 0; look() && k < longest_chain; ++k) {
      if (host_.see([&](auto&... seen) { return events_.happen(seen..., step_, mechanism_.state); }))
        stopped_ = true;
      mechanism_.enter(0);
      host_.look_anew();
      host_.take_jumps();
      host_.see([&](auto&, auto& system, auto&) { events_.see_relays(system); });
    }
    events_.pass();
    return stopped_;
  }

  bool make(double length) {
    const StepReport made = steps_.step(length);
    report_.code = made.code;
    report_.iterations += made.iterations;
    report_.factorisations += made.factorisations;
    static_cast<Violations&>(report_) = made;
    report_.coordinate = made.coordinate;
    report_.equation = made.equation;
    report_.equation_violation = made.equation_violation;
    report_.substeps = std::max(report_.substeps, made.substeps);
    report_.unconverged = report_.unconverged || made.unconverged;
    host_.look_anew();
    return made.ok();
  }

  bool again(double length) {
    steps_.undo();
    return make(length);
  }

  /// Of the part that has been made: to the first event that acts, where there is one. Others are noted with
  /// their times; they leave the motion as it is.
  bool find_events(double length) {
    constexpr int most_noted = 64;
    double low = 0;
    for (int k = 0; k < most_noted && look(); ++k) {
      if (!locate(low, length)) return false;
      if (events_.acts()) return true;
      host_.see([&](auto&... seen) { return events_.happen(seen..., step_, mechanism_.state); });
      events_.keep(Events::End::before);
      low = located_;
      if (!again(length)) return false;
    }
    return true;
  }

  /// Makes the part, of which the last look() saw that it went beyond a crossing, again so that it ends right
  /// behind the first one, later than `low`.
  bool locate(double low, double length) {
    double high = length, made = length;
    // Shares of the values at both ends: that of one which stays where it is gets smaller.
    double low_weight = 1, high_weight = 1;
    enum class Moved { none, lower, upper } last = Moved::none;
    events_.keep(Events::End::beyond);
    for (int round = 1; high - low > resolution_ && round < 80; ++round) {
      // Where that does not close in, halves do.
      const double share = round % 12 == 0 ? 0.5 : events_.first_share(low_weight, high_weight);
      const double at =
          std::clamp(low + share * (high - low), low + 0.5 * resolution_, high - 0.5 * resolution_);
      if (!again(at)) return false;
      made = at;
      if (look()) {
        high = at;
        events_.keep(Events::End::beyond);
        low_weight = last == Moved::upper ? 0.5 * low_weight : 1;
        high_weight = 1;
        last = Moved::upper;
      } else {
        low = at;
        events_.keep(Events::End::before);
        high_weight = last == Moved::lower ? 0.5 * high_weight : 1;
        low_weight = 1;
        last = Moved::lower;
      }
    }
    located_ = high;
    if (made == high) return true;
    if (!again(high)) return false;
    look();
    return true;
  }

  Host& host_;
  Events& events_;
  Mechanism& mechanism_;
  StepMaker& steps_;
  const double step_, resolution_;
  StepReport report_;
  double located_ = 0;  ///< s from the start of the part
  bool stopped_ = false;
};

}  // namespace mimbre
