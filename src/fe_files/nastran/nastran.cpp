#include "fe_files/nastran/nastran.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <map>
#include <memory>
#include <unordered_map>

#include "fe_files/mesh_builder.h"
#include "fe_files/nastran/nastran_build.h"
#include "fe_files/text.h"
#include "fe_files/units.h"

// Cards: MSC Nastran Quick Reference Guide, DMIG.

namespace mimbre::fe {

namespace {

bool is_dmig_head(const NastranCard& card) { return card.name == "DMIG" && card.field(1) == "0"; }

}  // namespace

ImportedMesh parse_nastran(TextFile& file) {
  NastranModel model;
  NastranLines lines(file);
  read_nastran_bulk(lines, model);
  return finish_nastran(model);
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
        mark, fmt::format("has {} DMIG matrices whose names begin with {}; specify the name. There are: {}",
                          fitting.size(), letter, shown(all)));
  return fitting.front();
}

std::vector<NastranMatrix> parse_dmig(NastranLines& lines, const std::vector<std::string>& names,
                                      const SolidMesh& mesh) {
  std::unordered_map<std::int64_t, int> by_label;
  for (std::size_t i = 0; i < mesh.labels.size(); ++i) by_label.emplace(mesh.labels[i], static_cast<int>(i));
  std::vector<NastranMatrix> matrices(names.size());
  std::vector<char> has_head(names.size(), 0);
  NastranCards cards(lines);
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
      const std::int64_t form = card.whole(2, "form of a matrix", 0),
                         type = card.whole(3, "type of a matrix", 1);
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

namespace {

/// What the reader of one file after another has; the first one's control selects the constraints that count.
struct Deck {
  NastranModel model;
  std::vector<std::string> included;
};

std::unique_ptr<NastranLines> bulk_of(const std::string& path, NastranModel& model) {
  auto lines = std::make_unique<NastranLines>(std::make_unique<TextFile>(path));
  if (read_nastran_control(*lines, model)) {
    model.has_control = true;
    return lines;
  }
  // There is no BEGIN BULK: the file is bulk data from its start, whatever was taken for case control.
  model.sets.clear();
  model.equation_sets.clear();
  return std::make_unique<NastranLines>(std::make_unique<TextFile>(path));
}

void read_deck(const std::string& path, Deck& deck) {
  const std::unique_ptr<NastranLines> lines = bulk_of(path, deck.model);
  read_nastran_bulk(*lines, deck.model);
  deck.included.insert(deck.included.end(), lines->included().begin(), lines->included().end());
}

void refuse_errors(NastranModel& model) {
  if (!model.errors.empty()) throw InputError(std::move(model.errors));
}

/// Turns the dofs of nodes whose displacements are in directions of their own into body axes.
void turn(const NastranBuild& build, FeMatrices& matrices, const Mark& mark) {
  using Eigen::Index;
  std::vector<Eigen::Triplet<double>> entries;
  bool any = false;
  const auto rows = static_cast<Index>(matrices.dofs.size());
  std::map<std::pair<int, int>, Index> row_of;
  for (Index r = 0; r < rows; ++r) {
    const Dof& dof = matrices.dofs[static_cast<std::size_t>(r)];
    row_of[{dof.node, dof.direction}] = r;
  }
  for (Index r = 0; r < rows; ++r) {
    const Dof& dof = matrices.dofs[static_cast<std::size_t>(r)];
    const Eigen::Matrix3d axes = build.directions(dof.node, {});
    if (axes.isIdentity(1e-9)) {
      entries.emplace_back(r, r, 1.0);
      continue;
    }
    any = true;
    const int kind = dof.direction / 3 * 3;
    for (int k = 0; k < 3; ++k) {
      const auto found = row_of.find({dof.node, kind + k});
      if (found == row_of.end())
        throw InputError(
            mark, fmt::format("node {} has its displacements in a turned system (CD) and not all three "
                              "of its {} in the matrices",
                              build.mesh.labels[static_cast<std::size_t>(dof.node)],
                              kind == 0 ? "translations" : "rotations"));
      entries.emplace_back(found->second, r, axes(k, dof.direction - kind));  // body from own
    }
  }
  if (!any) return;
  Eigen::SparseMatrix<double> T(rows, rows);
  T.setFromTriplets(entries.begin(), entries.end());
  for (Eigen::SparseMatrix<double>* matrix : {&matrices.stiffness, &matrices.mass}) {
    const Eigen::SparseMatrix<double> all = matrix->selfadjointView<Eigen::Lower>();
    const Eigen::SparseMatrix<double> product = T * all * T.transpose();
    *matrix = product.triangularView<Eigen::Lower>();
  }
}

}  // namespace

ImportedMatrices read_nastran_dmig(const std::string& punch_path, const std::string& bulk_path,
                                   const std::string& stiffness_name, const std::string& mass_name,
                                   const FileUnits& units) {
  Deck deck;
  deck.model.grids_only = true;
  read_deck(punch_path, deck);
  const Mark mark{punch_path, 0, 0};
  const std::vector<std::string> names = {choose_matrix(deck.model.matrices, stiffness_name, 'K', mark),
                                          choose_matrix(deck.model.matrices, mass_name, 'M', mark)};
  if (!bulk_path.empty()) read_deck(bulk_path, deck);
  if (deck.model.grids.empty())
    throw InputError(mark, "has no GRID cards; give the bulk-data file that has them");
  NastranBuild build(deck.model);
  refuse_errors(deck.model);
  NastranModel ignored;
  ignored.grids_only = true;
  const std::unique_ptr<NastranLines> lines = bulk_of(punch_path, ignored);
  std::vector<NastranMatrix> matrices = parse_dmig(*lines, names, build.mesh);
  SolidMesh mesh = build.mesh;
  mesh.nodes *= units.length;
  MatrixEntries entries{std::move(matrices[0].entries), std::move(matrices[1].entries)};
  ImportedMatrices result =
      finish_matrices(std::move(mesh), {}, std::move(entries), {}, SymmetricEntries::Repeated::refused,
                      matrices[0].stored, matrices[1].stored, mark, mark, units);
  turn(build, result.matrices, mark);
  return result;
}

std::optional<ImportedMesh> read_nastran(const std::string& path, const FileUnits& units) {
  check(units);
  Deck deck;
  read_deck(path, deck);
  if (!deck.model.has_elements() && !deck.model.matrices.empty()) return std::nullopt;
  ImportedMesh result = finish_nastran(deck.model);
  scale(result.mesh, units.length, units.mass, units.time);
  return result;
}

std::vector<std::string> nastran_includes(const std::string& path) {
  NastranLines lines(std::make_unique<TextFile>(path));
  std::string_view line;
  while (lines.next(line)) {
  }
  return lines.included();
}

}  // namespace mimbre::fe
