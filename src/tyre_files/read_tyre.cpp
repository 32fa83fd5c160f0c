#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "fe_files/text.h"
#include "math/elementary.h"
#include "tyre_files/parse_tyre.h"
#include "tyre_files/units.h"

namespace mimbre {
namespace tyre_files {
namespace {

using namespace forces::magic;

/// Stiffnesses of tyres are some 1e6 N/m; what is larger would only overflow later.
constexpr double largest = 1e12;

/// Underscores are written or not: Q_FZ2, QFZ2.
std::string bare(std::string_view key) {
  std::string result;
  for (const char c : key)
    if (c != '_') result += c;
  return result;
}

const std::map<std::string, Number>& numbers_by_key() {
  static const std::map<std::string, Number> names = [] {
    std::map<std::string, Number> all;
    for (int i = version + 1; i < count; ++i)
      all.emplace(bare(rows[static_cast<std::size_t>(i)].key), static_cast<Number>(i));
    // As PAC2002 and others call them.
    all.emplace("IP", inflpres);
    all.emplace("IPNOM", nompres);
    all.emplace("LFZ0", lfzo);
    return all;
  }();
  return names;
}

/// Forms of property files that share keys with the Magic Formula's, whose formulas are others.
bool has_other_formulas(const std::string& format) {
  static const std::set<std::string> others{"pac_mc", "pac89", "pac94", "521",    "5.2.1", "fiala",
                                            "ua",     "ftire", "ctire", "mf-mct", "cdtire"};
  return others.contains(format);
}

/// Sections whose keys are coefficients of the forces: one that is not known there, and does not leave out
/// its own term, would make a difference in another program.
bool holds_coefficients(const std::string& section) {
  static const std::set<std::string> sections{"SCALING_COEFFICIENTS",     "LONGITUDINAL_COEFFICIENTS",
                                              "OVERTURNING_COEFFICIENTS", "LATERAL_COEFFICIENTS",
                                              "ROLLING_COEFFICIENTS",     "ALIGNING_COEFFICIENTS"};
  return sections.contains(section);
}
/// Of the gyroscopic couple of a belt, and of how the carcass lets go: both are left out.
bool is_left_out(const std::string& key) {
  static const std::set<std::string> keys{"QTZ1", "MBELT", "LGYR"};
  return keys.contains(key);
}

/// Keys that describe the file, or in which range it was measured; they change no force.
bool says_no_number(const Property& property) {
  static const std::set<std::string> sections{"UNITS", "MDI_HEADER"};
  static const std::set<std::string> keys{"PROPERTY_FILE_FORMAT", "TYRESIDE", "FITTYP"};
  return sections.contains(property.section) || keys.contains(property.key);
}

/// 52, 61 or 62; 0 where the file does not specify it.
int version_said_by(const Property& property, std::vector<Diagnostic>& errors) {
  static const std::map<std::string, int> versions{{"5", 52},  {"6", 52},  {"21", 52}, {"51", 52},
                                                   {"52", 52}, {"60", 61}, {"61", 61}, {"62", 62}};
  if (property.key == "PROPERTY_FILE_FORMAT") {
    const std::string format = fe::lower(property.value);
    if (format == "pac2002" || format == "mf_05" || format == "mf-tyre" || format == "mftyre") return 52;
    if (format == "mf_61" || format == "mf61") return 61;
    if (format == "mf_62" || format == "mf62") return 62;
    if (has_other_formulas(format))
      errors.push_back({property.mark, fmt::format("PROPERTY_FILE_FORMAT is '{}', whose formulas are not "
                                                   "the Magic Formula's of 5.2, 6.1 and 6.2",
                                                   fe::shown(property.value))});
    return 0;
  }
  if (property.key != "FITTYP") return 0;
  const auto number = fe::to_real(property.value);
  const auto found = versions.find(number ? fmt::format("{}", *number) : std::string());
  if (found != versions.end()) return found->second;
  errors.push_back({property.mark, fmt::format("FITTYP is {}, which is no Magic Formula that is known here; "
                                               "6, 21, 51 and 52 (5.2), 60 and 61 (6.1) and 62 (6.2) are",
                                               fe::shown(property.value))});
  return 0;
}

class Reading {
 public:
  Reading(std::vector<Property> properties, Mark end)
      : properties_(std::move(properties)), end_(std::move(end)), units_(read_units(properties_, errors_)) {}

  TyreProperties read() {
    tyre_.numbers.resize(count);
    for (int i = 0; i < count; ++i) at(static_cast<Number>(i)) = row(static_cast<Number>(i)).neutral;
    read_version();
    for (const Property& property : properties_) read(property);
    check();
    if (!errors_.empty()) throw InputError(errors_);
    finish();
    return std::move(tyre_);
  }

 private:
  static const Row& row(Number number) { return rows[static_cast<std::size_t>(number)]; }
  double& at(Number number) { return tyre_.numbers[static_cast<std::size_t>(number)]; }
  void refuse(const Mark& mark, std::string message) { errors_.push_back({mark, std::move(message)}); }

  void read_version() {
    std::map<std::string, std::pair<int, int>> stated;  // by key: version and line
    for (const Property& property : properties_) {
      if (property.key == "TYRESIDE") tyre_.side = fe::lower(property.value);
      const int version = version_said_by(property, errors_);
      if (!version) continue;
      const auto [before, first] = stated.emplace(property.key, std::pair(version, property.mark.line));
      if (!first && before->second.first != version)
        refuse(property.mark, fmt::format("{} is given a second time, and otherwise; the first is in line {}",
                                          property.key, before->second.second));
    }
    // FITTYP is the more exact of the two.
    for (const char* const key : {"PROPERTY_FILE_FORMAT", "FITTYP"})
      if (const auto found = stated.find(key); found != stated.end()) tyre_.version = found->second.first;
    if (tyre_.version == 0 && errors_.empty())
      refuse(end_, "does not specify its Magic Formula: FITTYP = 6 (5.2), 61 or 62 is needed in [MODEL]");
    at(version) = tyre_.version;
  }

  void read(const Property& property) {
    if (says_no_number(property)) return;
    const auto found = numbers_by_key().find(bare(property.key));
    if (found == numbers_by_key().end()) {
      tyre_.unused.push_back(fmt::format("[{}] {}", property.section, property.key));
      const double neutral = property.key.starts_with('L') ? 1 : 0;
      if (holds_coefficients(property.section) && !is_left_out(property.key) &&
          fe::to_real(property.value).value_or(neutral) != neutral)
        tyre_.doubtful.push_back(fmt::format("{} = {} is not known", property.key, property.value));
      return;
    }
    const Number number = found->second;
    if (property.value.empty() && !property.text) {  // as if it were not there; need() names what is needed
      tyre_.unused.push_back(fmt::format("[{}] {}, which has no value", property.section, property.key));
      if (holds_coefficients(property.section))
        tyre_.doubtful.push_back(fmt::format("{} has no value", property.key));
      return;
    }
    const auto value = property.text ? std::nullopt : fe::to_real(property.value);
    if (!value) {
      refuse(property.mark,
             fmt::format("{} is '{}'; a finite number is needed", property.key, fe::shown(property.value)));
      return;
    }
    const double in_si = *value * units_.of(row(number).unit);
    if (std::abs(in_si) > largest) {
      refuse(property.mark,
             fmt::format("{} is {}: too large for a tyre", property.key, fe::shown(property.value)));
      return;
    }
    const auto [before, first] = given_.emplace(number, property.mark.line);
    if (!first && at(number) != in_si)
      refuse(property.mark,
             fmt::format("{} is given a second time, and otherwise; line {} has {}", property.key,
                         before->second, at(number) / units_.of(row(number).unit)));
    at(number) = in_si;
  }

  void need(Number number) {
    if (!given_.contains(number))
      refuse(end_, fmt::format("has no {}, which a tyre of version {}.{} needs", row(number).key,
                               tyre_.version / 10, tyre_.version % 10));
  }
  void need_positive(Number number) {
    const auto found = given_.find(number);
    if (found != given_.end() && !(at(number) > 0))
      refuse({end_.file, found->second, 1},
             fmt::format("{} is {}; it must be above 0", row(number).key, at(number)));
  }

  void need_not_negative(Number number) {
    const auto found = given_.find(number);
    if (found != given_.end() && at(number) < 0)
      refuse({end_.file, found->second, 1},
             fmt::format("{} is {}; it must not be below 0", row(number).key, at(number)));
  }

  /// A wheel that goes to the left is pushed to the right.
  void check_cornering_stiffness() {
    if (!given_.contains(pky1) || !given_.contains(pky2) || at(pky2) == 0) return;
    if (!(at(pky1) * mimbre::sin(at(pky4) * mimbre::atan(1 / at(pky2))) < 0))
      refuse({end_.file, given_[pky1], 1},
             fmt::format("PKY1 is {}: at the nominal load the cornering stiffness must be below 0, as in the "
                         "axes that property files are written for; with this sign the tyre pushes a wheel "
                         "further to the side to which it slips",
                         at(pky1)));
  }
  /// The force over the deflection x = ρ/R is q x + Q_FZ2 x², of which file or stiffness determine q.
  void check_vertical_stiffness() {
    const double slope = at(vertical_stiffness) * at(unloaded_radius) / at(fnomin);
    if (at(q_fz2) == 0) return;
    const bool reaches =
        given_.contains(q_fz1) ? at(q_fz1) * at(q_fz1) + 4 * at(q_fz2) > 0 : slope * slope > 4 * at(q_fz2);
    if (!reaches)
      refuse({end_.file, given_[q_fz2], 1},
             fmt::format("Q_FZ2 is {}: with {} there is no deflection at which the tyre carries its nominal "
                         "load",
                         at(q_fz2), given_.contains(q_fz1) ? "that Q_FZ1" : "that VERTICAL_STIFFNESS"));
  }

  void check() {
    for (int i = 0; i < count; ++i)
      if (row(static_cast<Number>(i)).needed) need(static_cast<Number>(i));
    for (const Number number : {unloaded_radius,
                                fnomin,
                                longvl,
                                lfzo,
                                pcx1,
                                pcy1,
                                nompres,
                                inflpres,
                                vertical_stiffness,
                                longitudinal_stiffness,
                                lateral_stiffness,
                                q_fz1,
                                q_re0,
                                pdx1,
                                pdy1,
                                pkx1,
                                lcx,
                                lcy,
                                lkx,
                                lky})
      need_positive(number);
    for (const Number number : {width, rim_radius, vertical_damping, bottom_stiff, lmux, lmuy, lmuv})
      need_not_negative(number);
    if (given_.contains(pky2) && at(pky2) == 0)
      refuse({end_.file, given_[pky2], 1},
             "PKY2 is 0; the cornering stiffness has its peak at that share of the nominal load");
    check_cornering_stiffness();
    check_vertical_stiffness();
    if (!given_.contains(q_fz1)) need(vertical_stiffness);
    if (tyre_.version > 60) {
      need(longitudinal_stiffness);
      need(lateral_stiffness);
    }
    if (at(rim_radius) >= at(unloaded_radius) && given_.contains(rim_radius) && at(unloaded_radius) > 0)
      refuse({end_.file, given_[rim_radius], 1},
             fmt::format("RIM_RADIUS {} m is not below UNLOADED_RADIUS {} m", at(rim_radius),
                         at(unloaded_radius)));
  }

  /// What follows from what was read.
  void finish() {
    const double R = at(unloaded_radius), F = at(fnomin);
    const double slope = at(vertical_stiffness) * R / F;
    // The stiffness of a file is that at the nominal load; Besselink et al. (2010), equation (4).
    if (!given_.contains(q_fz1)) at(q_fz1) = std::sqrt(std::max(slope * slope - 4 * at(q_fz2), 0.0));
    if (!given_.contains(vertical_stiffness))
      at(vertical_stiffness) = std::sqrt(at(q_fz1) * at(q_fz1) + 4 * at(q_fz2)) * F / R;
    if (!given_.contains(nompres)) at(nompres) = at(inflpres);
    if (!given_.contains(inflpres)) at(inflpres) = at(nompres);
    tyre_.unloaded_radius = R;
    tyre_.width = at(width);
    tyre_.rim_radius = at(rim_radius);
    tyre_.nominal_load = F;
    tyre_.pressure = at(inflpres);
    tyre_.nominal_pressure = at(nompres);
    // Rolling resistance of 5.2 and PAC2002 is Fz {…} (Fz/Fz₀)^QSY7, that since 6.1 Fz₀ {…} (Fz/Fz₀)^QSY7,
    // which is evaluated.
    if (tyre_.version < 60 && given_.contains(qsy7)) at(qsy7) += 1;
    // A file that has none, as those of version 5.2 do, has the nominal one, whatever that is.
    if (!given_.contains(nompres) && !given_.contains(inflpres)) at(nompres) = at(inflpres) = 1;
  }

  std::vector<Property> properties_;
  Mark end_;
  std::vector<Diagnostic> errors_;
  Units units_;
  std::map<Number, int> given_;  ///< in which line
  TyreProperties tyre_;
};

}  // namespace

TyreProperties parse_tyre(fe::TextFile& file) {
  std::vector<Property> properties = read_properties(file);
  return Reading(std::move(properties), {file.name(), 0, 0}).read();
}

}  // namespace tyre_files

TyreProperties read_tyre_properties(const std::filesystem::path& path) {
  fe::TextFile file(path.string());
  return tyre_files::parse_tyre(file);
}

}  // namespace mimbre
