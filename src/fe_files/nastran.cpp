#include "fe_files/nastran.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <unordered_map>

#include "fe_files/text.h"

// Cards: MSC Nastran Quick Reference Guide, DMIG, GRID, CORD2R.

namespace mimbre::fe {

namespace {

constexpr int kDeepest = 100;

std::int64_t integer(const NastranCard& card, std::size_t i, const char* what, std::int64_t missing) {
  const std::string_view field = card.field(i);
  if (field.empty()) return missing;
  const auto value = to_integer(field);
  if (!value) throw InputError(card.mark, fmt::format("'{}' is no {}", shown(field), what));
  return *value;
}

double real(const NastranCard& card, std::size_t i, const char* what) {
  const std::string_view field = card.field(i);
  if (field.empty()) return 0;
  const auto value = to_real(field);
  if (!value) throw InputError(card.mark, fmt::format("'{}' is no {}", shown(field), what));
  return *value;
}

Eigen::Vector3d point(const NastranCard& card, std::size_t first) {
  Eigen::Vector3d result;
  for (std::size_t i = 0; i < 3; ++i) result(static_cast<int>(i)) = real(card, first + i, "coordinate");
  return result;
}

std::string capitals(std::string_view text) {
  std::string result(text);
  std::transform(result.begin(), result.end(), result.begin(),
                 [](unsigned char c) { return static_cast<char>(std::toupper(c)); });
  return result;
}

bool is_dmig_head(const NastranCard& card) { return card.name == "DMIG" && card.field(1) == "0"; }

}  // namespace

void NastranGrids::read(TextFile& file) {
  NastranCards cards(file);
  NastranCard card;
  while (cards.next(card)) {
    if (card.name == "GRID") {
      Grid grid;
      grid.label = integer(card, 0, "node number", 0);
      if (grid.label <= 0) throw InputError(card.mark, "a GRID needs a number from 1");
      grid.position_system = integer(card, 1, "coordinate system", 0);
      grid.displacement_system = integer(card, 5, "coordinate system", 0);
      grid.position = point(card, 2);
      grid.mark = card.mark;
      grids_.push_back(grid);
    } else if (card.name == "GRDSET") {
      if (integer(card, 1, "coordinate system", 0) != 0 || integer(card, 5, "coordinate system", 0) != 0)
        throw InputError(card.mark, "GRDSET with coordinate systems is not read; say them on every GRID");
    } else if (card.name == "CORD2R") {
      const std::int64_t label = integer(card, 0, "coordinate system", 0);
      if (label <= 0) throw InputError(card.mark, "a coordinate system needs a number from 1");
      const bool is_new = systems_
                              .emplace(label, System{integer(card, 1, "coordinate system", 0), point(card, 2),
                                                     point(card, 5), point(card, 8), card.mark})
                              .second;
      if (!is_new) throw InputError(card.mark, fmt::format("coordinate system {} is there already", label));
    } else if (card.name.starts_with("CORD")) {
      other_systems_[integer(card, 0, "coordinate system", 0)] = card.name;
    } else if (is_dmig_head(card)) {
      matrices_.push_back(capitals(card.field(0)));
    }
  }
}

NastranGrids::Axes NastranGrids::axes(std::int64_t system, const Mark& mark, int depth) const {
  if (system == 0) return {};
  const auto found = systems_.find(system);
  if (found == systems_.end()) {
    const auto other = other_systems_.find(system);
    throw InputError(
        mark, other == other_systems_.end()
                  ? fmt::format("coordinate system {} is not there; give the file that has it", system)
                  : fmt::format("coordinate system {} is a {}; only CORD2R is read", system, other->second));
  }
  if (depth > kDeepest)
    throw InputError(found->second.mark, "coordinate systems refer to each other in a circle");
  const Axes reference = axes(found->second.reference, found->second.mark, depth + 1);
  const System& own = found->second;
  const Eigen::Vector3d z = own.on_z - own.origin, aside = own.in_xz - own.origin;
  const Eigen::Vector3d y = z.cross(aside);
  if (!(y.norm() > 1e-12 * z.norm() * aside.norm()))
    throw InputError(own.mark, "the three points of the coordinate system are on a line");
  Eigen::Matrix3d turn;
  turn.col(1) = y.normalized();
  turn.col(2) = z.normalized();
  turn.col(0) = turn.col(1).cross(turn.col(2));
  return {reference.origin + reference.rotation * own.origin, reference.rotation * turn};
}

SolidMesh NastranGrids::finish(const Mark& end) const {
  if (grids_.empty()) throw InputError(end, "has no GRID cards; give the bulk-data file that has them");
  SolidMesh mesh;
  mesh.nodes.resize(3, static_cast<Eigen::Index>(grids_.size()));
  std::unordered_map<std::int64_t, int> labels;
  std::map<std::int64_t, Axes> known;
  const auto axes_of = [&](std::int64_t system, const Mark& mark) {
    const auto found = known.find(system);
    return found != known.end() ? found->second : known.emplace(system, axes(system, mark)).first->second;
  };
  for (std::size_t i = 0; i < grids_.size(); ++i) {
    const Grid& grid = grids_[i];
    if (!labels.emplace(grid.label, static_cast<int>(i)).second)
      throw InputError(grid.mark, fmt::format("node {} is there already", grid.label));
    const Axes position = axes_of(grid.position_system, grid.mark);
    mesh.nodes.col(static_cast<Eigen::Index>(i)) = position.origin + position.rotation * grid.position;
    const Axes displacement = axes_of(grid.displacement_system, grid.mark);
    if (!displacement.rotation.isIdentity(1e-9))
      throw InputError(grid.mark,
                       fmt::format("node {} has its displacements in the turned system {}; leave CD empty",
                                   grid.label, grid.displacement_system));
    mesh.labels.push_back(grid.label);
  }
  return mesh;
}

std::string choose_matrix(const std::vector<std::string>& names, const std::string& wanted, char letter,
                          const Mark& mark) {
  const auto all = fmt::format("{}", fmt::join(names, ", "));
  if (!wanted.empty()) {
    const std::string name = capitals(wanted);
    if (std::find(names.begin(), names.end(), name) == names.end())
      throw InputError(mark, fmt::format("has no DMIG matrix {}; there are: {}", shown(name), shown(all)));
    return name;
  }
  std::vector<std::string> fitting;
  for (const std::string& name : names)
    if (name.starts_with(letter)) fitting.push_back(name);
  if (fitting.size() != 1)
    throw InputError(
        mark,
        fmt::format("has {} DMIG matrices whose names begin with {}; the name must be said. There are: {}",
                    fitting.size(), letter, shown(all)));
  return fitting.front();
}

std::vector<NastranMatrix> parse_dmig(TextFile& file, const std::vector<std::string>& names,
                                      const SolidMesh& mesh) {
  std::unordered_map<std::int64_t, int> by_label;
  for (std::size_t i = 0; i < mesh.labels.size(); ++i) by_label.emplace(mesh.labels[i], static_cast<int>(i));
  std::vector<NastranMatrix> matrices(names.size());
  std::vector<char> has_head(names.size(), 0);
  NastranCards cards(file);
  NastranCard card;
  const auto key = [&](std::string_view grid, std::string_view component) {
    const auto label = to_integer(grid), direction = to_integer(component);
    if (!label || (!component.empty() && !direction))
      throw InputError(card.mark,
                       fmt::format("'{}', '{}' is no node and component", shown(grid), shown(component)));
    if (component.empty() || *direction == 0)
      throw InputError(card.mark,
                       fmt::format("{} is a scalar point (component 0), a modal dof of a reduced model; the "
                                   "matrices must be those of the nodes",
                                   *label));
    if (*direction < 1 || *direction > 6)
      throw InputError(card.mark,
                       fmt::format("component {} of node {} is not in 1 to 6", *direction, *label));
    const auto node = by_label.find(*label);
    if (node == by_label.end()) throw InputError(card.mark, fmt::format("node {} has no GRID card", *label));
    return dof_key({node->second, static_cast<int>(*direction) - 1});
  };
  while (cards.next(card)) {
    if (card.name != "DMIG") continue;
    const auto name = std::find(names.begin(), names.end(), capitals(card.field(0)));
    if (name == names.end()) continue;
    const auto index = static_cast<std::size_t>(name - names.begin());
    NastranMatrix& matrix = matrices[index];
    if (is_dmig_head(card)) {
      if (has_head[index]) throw InputError(card.mark, fmt::format("the matrix {} is there twice", *name));
      has_head[index] = 1;
      const std::int64_t form = integer(card, 2, "form of a matrix", 0),
                         type = integer(card, 3, "type of a matrix", 1);
      if (form != 1 && form != 2 && form != 6 && form != 9)
        throw InputError(
            card.mark, fmt::format("form {} of the matrix {}: 6 (symmetric), 1 or 9 is needed", form, *name));
      if (type != 1 && type != 2)
        throw InputError(card.mark,
                         fmt::format("type {} of the matrix {}: 1 or 2 (real) is needed", type, *name));
      matrix.stored = form == 6 ? SymmetricEntries::Stored::triangle : SymmetricEntries::Stored::full;
      continue;
    }
    if (!has_head[index])
      throw InputError(card.mark, fmt::format("a column of {} stands before its head", *name));
    if (matrix.stored == SymmetricEntries::Stored::full && (card.field(2).empty() || card.field(2) == "0"))
      throw InputError(card.mark,
                       fmt::format("the columns of {} are only numbered (rectangular form); their nodes and "
                                   "components are needed",
                                   *name));
    const int column = key(card.field(1), card.field(2));
    for (std::size_t i = 4; i < card.fields.size(); i += 4) {
      if (card.field(i).empty()) continue;
      const int row = key(card.field(i), card.field(i + 1));
      const auto value = to_real(card.field(i + 2));
      if (!value)
        throw InputError(card.mark, fmt::format("'{}' is no finite value in a column of {}",
                                                shown(card.field(i + 2)), *name));
      matrix.entries.add(row, column, *value);
    }
  }
  return matrices;
}

ImportedMatrices read_nastran_dmig(const std::string& punch_path, const std::string& bulk_path,
                                   const std::string& stiffness_name, const std::string& mass_name,
                                   const FileUnits& units) {
  NastranGrids grids;
  TextFile first(punch_path);
  grids.read(first);
  const Mark mark{punch_path, 0, 0};
  std::vector<std::string> names = {choose_matrix(grids.matrices(), stiffness_name, 'K', mark),
                                    choose_matrix(grids.matrices(), mass_name, 'M', mark)};
  if (!bulk_path.empty()) {
    TextFile bulk(bulk_path);
    grids.read(bulk);
  }
  SolidMesh mesh = grids.finish(mark);
  TextFile second(punch_path);
  std::vector<NastranMatrix> matrices = parse_dmig(second, names, mesh);
  mesh.nodes *= units.length;
  MatrixEntries entries{std::move(matrices[0].entries), std::move(matrices[1].entries)};
  return finish_matrices(std::move(mesh), {}, std::move(entries), {}, SymmetricEntries::Repeated::refused,
                         matrices[0].stored, matrices[1].stored, mark, mark, units);
}

}  // namespace mimbre::fe
