#pragma once
#include <array>
#include <stdexcept>

#include "app/common.h"
#include "app/reproduce/reproduce_tables.h"

/// What the makers of tables share.
namespace mimbre::app {

using Formulation = spec::Simulation::Formulation;
using Report = std::function<void(const ReproducedRow&)>;
using Numbers = std::vector<std::optional<double>>;

inline constexpr std::array formulations{Formulation::natural, Formulation::relative};

inline std::string formulation_name(Formulation formulation) {
  return formulation == Formulation::natural ? "natural" : "relative";
}

/// Collects rows; a measurement that fails leaves its message.
class Rows {
 public:
  explicit Rows(const Report& report) : report_(report) {}

  template <class Measure>
  void add(ReproducedRow row, Measure&& measure) {
    report_(row);
    try {
      row.ours = measure(row);
    } catch (const Failure&) {
      throw;
    } catch (const std::exception& error) {
      row.note = error.what();
    }
    rows_.push_back(std::move(row));
  }

  /// Rows of one series over another, column by column: what does not depend on the machine.
  void add_quotient(const std::string& name, const std::string& above, const std::string& below) {
    std::vector<ReproducedRow> quotients;
    for (const ReproducedRow& a : rows_)
      for (const ReproducedRow& b : rows_) {
        if (a.series != above || b.series != below || a.column != b.column) continue;
        ReproducedRow row{name, a.column, "1", {}, {}, {}};
        if (a.published && b.published) row.published = *a.published / *b.published;
        if (a.ours && b.ours)
          row.ours = *a.ours / *b.ours;
        else
          row.note = "one of the two failed";
        quotients.push_back(row);
      }
    rows_.insert(rows_.end(), quotients.begin(), quotients.end());
  }

  std::vector<ReproducedRow> take() { return std::move(rows_); }

 private:
  const Report& report_;
  std::vector<ReproducedRow> rows_;
};

}  // namespace mimbre::app
