#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "fe_files/text.h"
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

/// Keys that say what the file is, or in which range it was measured; they change no force.
bool says_no_number(const Property& property) {
  static const std::set<std::string> sections{"UNITS", "MDI_HEADER"};
  static const std::set<std::string> keys{"PROPERTY_FILE_FORMAT", "TYRESIDE", "FITTYP"};
  return sections.contains(property.section) || keys.contains(property.key);
}

/// 52, 61 or 62; 0 where the file does not say it.
int version_said_by(const Property& property, std::vector<Diagnostic>& errors) {
  static const std::map<std::string, int> versions{{"5", 52},  {"6", 52},  {"21", 52}, {"51", 52},
                                                   {"52", 52}, {"60", 61}, {"61", 61}, {"62", 62}};
  if (property.key == "PROPERTY_FILE_FORMAT") {
    const std::string format = fe::lower(property.value);
    if (format == "pac2002" || format == "mf_05" || format == "mf-tyre" || format == "mftyre") return 52;
    if (format == "mf_61" || format == "mf61") return 61;
    if (format == "mf_62" || format == "mf62") return 62;
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
    for (const Property& property : properties_) {
      const int said = version_said_by(property, errors_);
      // FITTYP is the more exact of the two.
      if (said && (tyre_.version == 0 || property.key == "FITTYP")) tyre_.version = said;
      if (property.key == "TYRESIDE") tyre_.side = fe::lower(property.value);
    }
    if (tyre_.version == 0 && errors_.empty())
      refuse(end_, "says nowhere which Magic Formula it is: FITTYP = 6 (5.2), 61 or 62 is needed in [MODEL]");
    at(version) = tyre_.version;
  }

  void read(const Property& property) {
    if (says_no_number(property)) return;
    const auto found = numbers_by_key().find(bare(property.key));
    if (found == numbers_by_key().end()) {
      tyre_.unused.push_back(fmt::format("[{}] {}", property.section, property.key));
      return;
    }
    const Number number = found->second;
    if (property.value.empty() && !property.text) {  // as if it were not there; need() names what is needed
      tyre_.unused.push_back(fmt::format("[{}] {}, which has no value", property.section, property.key));
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

  void check() {
    for (int i = 0; i < count; ++i)
      if (row(static_cast<Number>(i)).needed) need(static_cast<Number>(i));
    for (const Number number : {unloaded_radius, fnomin, longvl, lfzo, pcx1, pcy1, nompres, inflpres,
                                vertical_stiffness, longitudinal_stiffness, lateral_stiffness})
      need_positive(number);
    if (given_.contains(pky2) && at(pky2) == 0)
      refuse({end_.file, given_[pky2], 1},
             "PKY2 is 0; the cornering stiffness has its peak at that share of the nominal load");
    if (!given_.contains(q_fz1)) need(vertical_stiffness);
    if (tyre_.version > 60) {
      need(longitudinal_stiffness);
      need(lateral_stiffness);
    }
    if (at(vertical_damping) < 0)
      refuse({end_.file, given_[vertical_damping], 1},
             fmt::format("VERTICAL_DAMPING is {}; it must not be below 0", at(vertical_damping)));
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
    // A file that says none, as those of version 5.2 do, has the nominal one, whatever that is.
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
