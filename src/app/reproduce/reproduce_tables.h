#pragma once
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "app/reproduce/reproduce_lab.h"

namespace mimbre::app {

/// One number of a published table beside ours. A series and a column name it: "relative" and "A+L".
struct ReproducedRow {
  std::string series, column, unit;
  std::optional<double> published, ours;  ///< nothing: not published, or the run failed see the note
  std::string note;
  std::optional<double> ratio() const {
    return published && ours ? std::optional(*ours / *published) : std::nullopt;
  }
};

/// A published table, and the runs that make ours.
struct PublishedTable {
  std::string name, title;
  /// `report` is called with the name of each row before it is measured.
  std::function<std::vector<ReproducedRow>(Lab& lab, const std::function<void(const ReproducedRow&)>& report)>
      make;
};
const std::vector<PublishedTable>& published_tables();
/// Those among them of chapter 4.
std::vector<PublishedTable> deflection_tables();
/// And those of the bases that chapter 1 surveys.
std::vector<PublishedTable> basis_tables();

}  // namespace mimbre::app
