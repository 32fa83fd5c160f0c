#include <fmt/format.h>

#include <array>
#include <cmath>

#include "fe_files/nastran/nastran_model.h"
#include "fe_files/text.h"

// MSC Nastran Quick Reference Guide, C cards.

namespace mimbre::fe {

namespace {

using Eigen::Vector3d;

bool is_whole(const NastranCard& card, std::size_t i) { return to_integer(card.field(i)).has_value(); }

/// Nodes from the field `first` on; those behind `needed` may be blank all together.
std::size_t add_nodes(NastranModel& model, const NastranCard& card, std::size_t first, int needed, int all) {
  const std::size_t begin = model.element_nodes.size();
  for (int i = 0; i < all; ++i) {
    const std::size_t field = first + static_cast<std::size_t>(i);
    const std::int64_t node = i < needed ? card.label(field, "node") : card.whole(field, "node", 0);
    if (node < 0) card.fail(fmt::format("{} is no node", node));
    model.element_nodes.push_back(node);
  }
  return begin;
}

/// How many of the nodes from `from` to `to` a card has; its first stands in the field 2.
int count_nodes(const NastranCard& card, int from, int to) {
  int count = 0;
  for (int i = from; i < to; ++i) {
    const std::size_t field = 2 + static_cast<std::size_t>(i);
    if (!card.blank(field) && card.field(field) != "0") ++count;
  }
  return count;
}

constexpr std::size_t kMaxNodes = 20;

struct SolidCard {
  const char* name;
  ElementType linear, quadratic;
};
constexpr SolidCard kSolids[] = {
    {"CTETRA", ElementType::tet4, ElementType::tet10},
    {"CHEXA", ElementType::hex8, ElementType::hex20},
    {"CPENTA", ElementType::wedge6, ElementType::wedge15},
    {"CPYRAM", ElementType::pyramid5, ElementType::pyramid13},
    {"CPYRA", ElementType::pyramid5, ElementType::pyramid13},
};

/// Where each of our nodes stands on the card: those between the two faces come before those of the far face.
int card_place(ElementType type, int node) {
  if (type == ElementType::hex20 && node >= 12) return node < 16 ? node + 4 : node - 4;
  if (type == ElementType::wedge15 && node >= 9) return node < 12 ? node + 3 : node - 3;
  return node;
}

void read_solid(NastranModel& model, const NastranCard& card, const SolidCard& kind) {
  NastranSolid solid;
  solid.label = card.label(0, "element number");
  solid.property = card.whole(1, "property", solid.label);
  solid.place = model.place(card.mark);
  const int corners = node_count(kind.linear), all = node_count(kind.quadratic);
  const int middles = count_nodes(card, corners, all);
  solid.type = middles == 0 ? kind.linear : kind.quadratic;
  const std::size_t first = add_nodes(model, card, 2, corners, middles == 0 ? corners : all);
  solid.first = first;
  if (middles > 0) {
    std::array<std::int64_t, kMaxNodes> ordered{};
    for (int i = 0; i < all; ++i)
      ordered[static_cast<std::size_t>(i)] =
          model.element_nodes[first + static_cast<std::size_t>(card_place(solid.type, i))];
    std::copy_n(ordered.begin(), all, model.element_nodes.begin() + static_cast<std::ptrdiff_t>(first));
  }
  model.solids.push_back(solid);
}

struct ShellCard {
  const char* name;
  ElementType type;
  int corners;
  std::size_t angle, flag, thickness;  ///< fields; flag 0: none
};
// THETA or MCID stands at `angle`, ZOFFS behind it.
constexpr ShellCard kShells[] = {
    {"CQUAD4", ElementType::quad4, 4, 6, 9, 10},   {"CQUADR", ElementType::quad4, 4, 6, 9, 10},
    {"CTRIA3", ElementType::tri3, 3, 5, 9, 10},    {"CTRIAR", ElementType::tri3, 3, 5, 9, 10},
    {"CQUAD8", ElementType::quad8, 4, 14, 16, 10}, {"CTRIA6", ElementType::tri6, 3, 8, 13, 10},
};

void read_shell(NastranModel& model, const NastranCard& card, const ShellCard& kind) {
  NastranShell shell;
  shell.label = card.label(0, "element number");
  shell.property = card.whole(1, "property", shell.label);
  shell.place = model.place(card.mark);
  int all = node_count(kind.type);
  if (count_nodes(card, kind.corners, all) == 0) all = kind.corners;
  shell.type = all == 3 ? ElementType::tri3 : all == 4 ? ElementType::quad4 : kind.type;
  shell.first = add_nodes(model, card, 2, kind.corners, all);
  if (!card.blank(kind.angle)) {
    // MCID is a whole number, THETA a real one.
    if (is_whole(card, kind.angle))
      shell.system = card.whole(kind.angle, "coordinate system");
    else
      shell.angle = card.real(kind.angle, "angle");
  }
  if (!card.blank(kind.angle + 1)) shell.offset = card.real(kind.angle + 1, "offset");
  const std::int64_t flag = card.whole(kind.flag, "flag of the thicknesses", 0);
  shell.relative_thickness = flag == 1;
  // CTRIA6: T1 to T3 behind ZOFFS; CQUAD8: behind its nodes.
  for (int i = 0; i < kind.corners; ++i)
    shell.thickness[static_cast<std::size_t>(i)] =
        card.real(kind.thickness + static_cast<std::size_t>(i), "thickness");
  model.shells.push_back(shell);
}

/// Direction of the y axis: a node or a vector; false: the card has none.
bool read_direction(const NastranCard& card, std::size_t first, Vector3d& direction, std::int64_t& node) {
  if (card.blank(first) && card.blank(first + 1) && card.blank(first + 2)) return false;
  if (is_whole(card, first) && card.blank(first + 1) && card.blank(first + 2))
    node = card.label(first, "node of the direction");
  else
    direction = card.vector(first, "part of a direction");
  return true;
}

/// What CBAR, CBEAM, BAROR and BEAMOR have in the same fields.
void read_common(const NastranCard& card, NastranBar& bar) {
  bar.property = card.whole(1, "property", 0);
  bar.has_direction = read_direction(card, 4, bar.direction, bar.direction_node);
  const std::string_view axes = card.field(7);
  if (axes.empty()) return;
  // CBEAM may have a built-in twist (BIT, a real number) here; CBAR had a flag once.
  if (to_real(axes)) {
    if (card.name == "CBEAM") card.fail("a twist (BIT) is not read");
    return;
  }
  bar.axes = capitals(axes);
  if (bar.axes.size() != 3 || bar.axes.find_first_not_of("GBOE") != std::string::npos)
    card.fail(fmt::format("'{}' is no OFFT, such as GGG", shown(axes)));
}

void read_bar(NastranModel& model, const NastranCard& card) {
  NastranBar bar;
  bar.label = card.label(0, "element number");
  bar.beam = card.name == "CBEAM";
  bar.place = model.place(card.mark);
  for (std::size_t i = 0; i < 2; ++i) bar.nodes[i] = card.label(2 + i, "node");
  read_common(card, bar);
  for (std::size_t i = 0; i < 2; ++i) {
    bar.released[i] = card.components(8 + i);
    bar.offsets[i] = card.vector(10 + 3 * i, "offset");
  }
  model.bars.push_back(bar);
}

void read_bar_defaults(NastranModel& model, const NastranCard& card) {
  NastranBar& defaults = card.name == "BAROR" ? model.bar_defaults : model.beam_defaults;
  read_common(card, defaults);
}

void read_rod(NastranModel& model, const NastranCard& card) {
  NastranBar rod;
  rod.label = card.label(0, "element number");
  rod.property = card.whole(1, "property", rod.label);
  rod.place = model.place(card.mark);
  rod.rod = true;
  for (std::size_t i = 0; i < 2; ++i) rod.nodes[i] = card.label(2 + i, "node");
  model.bars.push_back(rod);
}

/// Its property stands on the card, and is kept under the element's number, negative.
void read_conrod(NastranModel& model, const NastranCard& card) {
  NastranBar rod;
  rod.label = card.label(0, "element number");
  rod.property = -rod.label;
  rod.place = model.place(card.mark);
  rod.rod = true;
  for (std::size_t i = 0; i < 2; ++i) rod.nodes[i] = card.label(1 + i, "node");
  NastranBarProperty property;
  property.material = card.label(3, "material");
  property.section.area = card.real(4, "area");
  property.section.J = card.real(5, "torsion constant");
  property.section.mass = card.real(7, "mass by length");
  property.place = rod.place;
  model.bar_properties[rod.property] = property;
  model.bars.push_back(rod);
}

void read_panel(NastranModel& model, const NastranCard& card) {
  NastranPanel panel;
  panel.label = card.label(0, "element number");
  panel.property = card.whole(1, "property", panel.label);
  panel.place = model.place(card.mark);
  for (std::size_t i = 0; i < 4; ++i) panel.nodes[i] = card.label(2 + i, "node");
  model.panels.push_back(panel);
}

int component(const NastranCard& card, std::size_t i) {
  const std::int64_t value = card.whole(i, "component", 0);
  if (value < 0 || value > 6) card.fail(fmt::format("component {} is not in 1 to 6", value));
  return static_cast<int>(value) - 1;
}

/// Springs and masses between components: `value` and `property`: fields, one of them −1; `nodes`: the first
/// of G1, C1, G2, C2, or of S1, S2 where they are scalar points.
void read_scalar(NastranModel& model, const NastranCard& card, int value, int property, std::size_t nodes,
                 bool points, std::vector<NastranScalar>& list) {
  NastranScalar one;
  one.label = card.label(0, "element number");
  one.card = card.name;
  one.place = model.place(card.mark);
  if (value >= 0) one.value = card.real(static_cast<std::size_t>(value), "value");
  if (property >= 0) one.property = card.whole(static_cast<std::size_t>(property), "property", one.label);
  for (std::size_t i = 0; i < 2; ++i) {
    one.nodes[i] = card.whole(nodes + (points ? i : 2 * i), "node", 0);
    if (!points) one.components[i] = component(card, nodes + 2 * i + 1);
    if (one.nodes[i] < 0) card.fail(fmt::format("{} is no node", one.nodes[i]));
    if (points && one.nodes[i] > 0 && !model.is_scalar_point(one.nodes[i]))
      model.scalar_points.push_back({one.nodes[i], one.nodes[i]});
  }
  list.push_back(std::move(one));
}

void read_bush(NastranModel& model, const NastranCard& card) {
  NastranBush bush;
  bush.label = card.label(0, "element number");
  bush.property = card.whole(1, "property", bush.label);
  bush.place = model.place(card.mark);
  bush.nodes = {card.label(2, "node"), card.whole(3, "node", 0)};
  read_direction(card, 4, bush.direction, bush.direction_node);
  if (!card.blank(7)) bush.system = card.whole(7, "coordinate system");
  bush.place_along = card.real(8, "place of the spring", 0.5);
  if (!card.blank(9) && card.whole(9, "coordinate system") >= 0) bush.offset_system = card.whole(9, "system");
  bush.offset = card.vector(10, "place of the spring");
  model.bushes.push_back(bush);
}

/// Two to four values of the inertia about the centre: I11, I21, I22, I31, I32, I33, the products with their
/// sign.
void read_mass(NastranModel& model, const NastranCard& card) {
  NastranMass mass;
  mass.label = card.label(0, "element number");
  mass.node = card.label(1, "node");
  mass.system = card.whole(2, "coordinate system", 0);
  mass.place = model.place(card.mark);
  mass.mass = card.real(3, "mass");
  mass.offset = card.vector(4, "place of the mass");
  const auto at = [&](std::size_t i) { return card.real(8 + i, "moment of inertia"); };
  mass.inertia << at(0), -at(1), -at(3), -at(1), at(2), -at(4), -at(3), -at(4), at(5);
  model.masses.push_back(mass);
}

/// CONM1 is a 6 × 6 matrix: one that a rigid part can have is taken.
void read_mass_matrix(NastranModel& model, const NastranCard& card) {
  NastranMass mass;
  mass.label = card.label(0, "element number");
  mass.node = card.label(1, "node");
  mass.system = card.whole(2, "coordinate system", 0);
  mass.place = model.place(card.mark);
  Eigen::Matrix<double, 6, 6> M;
  std::size_t field = 3;
  for (int i = 0; i < 6; ++i)
    for (int j = 0; j <= i; ++j) M(i, j) = M(j, i) = card.real(field++, "mass");
  mass.mass = M(0, 0);
  const Eigen::Matrix3d moment = M.topRightCorner<3, 3>();  // −m r×
  const double scale = M.topLeftCorner<3, 3>().cwiseAbs().maxCoeff();
  if (mass.mass != 0) mass.offset = Vector3d(moment(1, 2), moment(2, 0), moment(0, 1)) / mass.mass;
  const Vector3d& r = mass.offset;
  Eigen::Matrix3d cross;
  cross << 0, -r.z(), r.y(), r.z(), 0, -r.x(), -r.y(), r.x(), 0;
  const double moments = moment.cwiseAbs().maxCoeff();
  if (!(M.topLeftCorner<3, 3>() - mass.mass * Eigen::Matrix3d::Identity()).isZero(1e-6 * scale) ||
      !(moment + mass.mass * cross).isZero(1e-6 * moments))
    card.fail(
        "its matrix is none of a rigid part: the masses in x, y, z must be equal, the moments of mass skew");
  mass.inertia = M.bottomRightCorner<3, 3>() + mass.mass * cross * cross;
  model.masses.push_back(mass);
}

}  // namespace

bool read_nastran_element(NastranModel& model, const NastranCard& card) {
  const std::string& name = card.name;
  for (const SolidCard& kind : kSolids)
    if (name == kind.name) return read_solid(model, card, kind), true;
  for (const ShellCard& kind : kShells)
    if (name == kind.name) return read_shell(model, card, kind), true;
  if (name == "CBAR" || name == "CBEAM") {
    read_bar(model, card);
  } else if (name == "BAROR" || name == "BEAMOR") {
    read_bar_defaults(model, card);
  } else if (name == "CROD" || name == "CTUBE") {
    read_rod(model, card);
  } else if (name == "CSHEAR") {
    read_panel(model, card);
  } else if (name == "CONROD") {
    read_conrod(model, card);
  } else if (name == "CELAS1") {
    read_scalar(model, card, -1, 1, 2, false, model.springs);
  } else if (name == "CELAS2") {
    read_scalar(model, card, 1, -1, 2, false, model.springs);
  } else if (name == "CELAS3") {
    read_scalar(model, card, -1, 1, 2, true, model.springs);
  } else if (name == "CELAS4") {
    read_scalar(model, card, 1, -1, 2, true, model.springs);
  } else if (name == "CMASS1") {
    read_scalar(model, card, -1, 1, 2, false, model.scalar_masses);
  } else if (name == "CMASS2") {
    read_scalar(model, card, 1, -1, 2, false, model.scalar_masses);
  } else if (name == "CMASS3") {
    read_scalar(model, card, -1, 1, 2, true, model.scalar_masses);
  } else if (name == "CMASS4") {
    read_scalar(model, card, 1, -1, 2, true, model.scalar_masses);
  } else if (name == "CBUSH") {
    read_bush(model, card);
  } else if (name == "CONM2") {
    read_mass(model, card);
  } else if (name == "CONM1") {
    read_mass_matrix(model, card);
  } else {
    return false;
  }
  return true;
}

}  // namespace mimbre::fe
