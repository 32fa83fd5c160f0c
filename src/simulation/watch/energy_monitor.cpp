#include "simulation/watch/energy_monitor.h"

#include <fmt/format.h>

#include "simulation/describe/names.h"

namespace mimbre {
namespace {

/// Where nothing is at play a share would be one of round-off.
std::string part(double energy, double at_play, double nothing) {
  if (!(at_play > nothing)) return fmt::format("{:.3g} J, where nothing moves or is stored", energy);
  const double percent = 100 * energy / at_play;
  return fmt::format("{:.3g} J, {} % of the {:.3g} J at play", energy,
                     percent > 99 ? fmt::format("{:.0f}", percent) : fmt::format("{:.2g}", percent), at_play);
}

std::string steps_a_period(const EnergyMeter::Unresolved& fastest) {
  if (fastest.steps_per_period < 5) return "fewer than 5 steps or parts of repeated ones a period";
  return fmt::format("about {:.0f} steps or parts of repeated ones a period", fastest.steps_per_period);
}

}  // namespace

void EnergyMonitor::start(const EnergyMeter& meter) {
  *this = {};
  highest = meter.balance().total();
  lowest_potential = highest - meter.balance().kinetic;
}

void EnergyMonitor::watch(const EnergyMeter& meter, double time) {
  const EnergyBalance& e = meter.balance();
  highest = std::max(highest, e.total());
  lowest_potential = std::min(lowest_potential, e.total() - e.kinetic);
  drive_turnover += std::abs(e.drive_work - drive_work);
  drive_work = e.drive_work;
  most = std::max(most, e.numerical);
  least = std::min(least, e.numerical);
  rise = std::max(rise, e.numerical - least);
  fall = std::max(fall, most - e.numerical);
  const double input = e.numerical - last;  // of all its parts, where a step is repeated in parts
  last = e.numerical;
  if (input > largest_gain.energy) largest_gain = {input, time, meter.last_place()};
  if (input < largest_loss.energy) largest_loss = {input, time, meter.last_place()};
}

std::string EnergyMonitor::warning(const Compiled& model, const EnergyMeter& meter, double nothing) const {
  const double play = at_play(), dissipated = std::max(0.0, meter.balance().dissipated),
               limit = std::max(share * play, nothing), swing = std::max(share_of_swing * play, nothing);
  if (most > limit + share * dissipated || rise > swing + share * dissipated)
    return fmt::format(
        "the numerics fed in {} (limit {:g} %); the most in the step to t = {:.6g} s, {:.3g} J at {}: do not "
        "trust this run; take a smaller step or an integrator with damping (the default, generalised-alpha)",
        part(std::max(most, rise), play, nothing), 100 * share, largest_gain.time, largest_gain.energy,
        place_name(model, largest_gain.place));
  const double by_dampers = share_of_dissipation * dissipated;
  const EnergyMeter::Unresolved fastest = meter.most_unresolved(nothing);
  const bool spring = fastest.place.kind == EnergyMeter::Place::Kind::element &&
                      !on_road(model.elements[fastest.place.index].measure);
  if (spring && fastest.steps_per_period < few_steps &&
      -least > std::max({share_of_vibration * fastest.at_play, by_dampers, nothing}) && -least <= limit)
    return fmt::format(
        "the numerics took out {:.3g} J, {:.2g} % of the {:.3g} J at play in {} (limit {:g} %), which "
        "vibrates with {}: it dies "
        "out too early; take a smaller step",
        -least, 100 * -least / fastest.at_play, fastest.at_play, place_name(model, fastest.place),
        100 * share_of_vibration, steps_a_period(fastest));
  if (-least > std::max(limit, by_dampers) || fall > std::max(swing, by_dampers)) {
    std::string text = fmt::format("the numerics took out {} (limit {:g} %)",
                                   part(std::max(-least, fall), play, nothing), 100 * share);
    if (dissipated > limit)
      text += fmt::format(", and {:.2g} % of the {:.3g} J that dampers took (limit {:g} %)",
                          100 * std::max(-least, fall) / dissipated, dissipated, 100 * share_of_dissipation);
    text += fmt::format("; the most in the step to t = {:.6g} s, {:.3g} J", largest_loss.time,
                        -largest_loss.energy);
    if (fastest.place.kind != EnergyMeter::Place::Kind::none)
      text += fmt::format("; the steps are longest for {} ({})", place_name(model, fastest.place),
                          steps_a_period(fastest));
    return text + ": vibrations and motions die out too early; take a smaller step";
  }
  return {};
}

}  // namespace mimbre
