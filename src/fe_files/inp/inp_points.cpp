#include <fmt/format.h>

#include <cmath>

#include "fe_files/inp/inp_model.h"
#include "fe_files/text.h"

namespace mimbre::fe {
namespace {

using PointKind = InpPointProperty::Kind;

int direction_field(InpModel& model, std::string_view& line) {
  const std::string_view field = next_field(line);
  const auto value = to_integer(field);
  if (!value || *value < 1 || *value > 6)
    model.lines.file().fail(fmt::format("'{}' is no dof (1 to 6) of a spring", shown(field)));
  return static_cast<int>(*value) - 1;
}

}  // namespace

bool read_inp_point_property(InpModel& model, const InpKeyword& keyword) {
  InpPointProperty property;
  property.mark = keyword.mark;
  if (keyword.name == "MASS")
    property.kind = PointKind::mass;
  else if (keyword.name == "ROTARY INERTIA")
    property.kind = PointKind::inertia;
  else if (keyword.name == "SPRING")
    property.kind = PointKind::spring;
  else
    return false;
  property.element_set = needed(keyword, "ELSET");
  if (keyword.find("NONLINEAR"))
    throw InputError(keyword.mark, "a nonlinear *SPRING is not read: a flexible body is linear");
  if (keyword.find("ORIENTATION"))
    throw InputError(keyword.mark, fmt::format("*{} with ORIENTATION is not read", keyword.name));
  // Of elements that are left out nothing is needed.
  bool between = false;
  const auto& elements = model.known_element_set(property.element_set, keyword.mark).elements;
  if (elements.empty()) return true;
  for (const int index : elements)
    between =
        between ||
        model.types[static_cast<std::size_t>(model.elements[static_cast<std::size_t>(index)].type)].kind ==
            InpType::Kind::spring_between;
  if (property.kind == PointKind::inertia) {
    const auto v = inp_numbers(model, keyword, 6, "I11, I22, I33, I12, I13, I23");
    std::copy(v.begin(), v.end(), property.values.begin());
  } else {
    if (property.kind == PointKind::spring && between) {
      std::string_view line;
      if (!model.lines.next_data(line))
        throw InputError(keyword.mark, "*SPRING needs a line with its two dofs");
      for (int& direction : property.directions) direction = direction_field(model, line);
    }
    property.values[0] =
        inp_numbers(model, keyword, 1, property.kind == PointKind::mass ? "the mass" : "the stiffness")[0];
    if (!(property.values[0] >= 0)) model.lines.file().fail("must not be negative");
  }
  model.point_properties.push_back(std::move(property));
  return true;
}

namespace {

/// Masses and springs without a value would be missing from the body.
void require_values(const InpModel& model, const std::vector<char>& have) {
  for (std::size_t k = 0; k < model.elements.size(); ++k) {
    const InpElement& element = model.elements[k];
    const InpType::Kind kind = model.types[static_cast<std::size_t>(element.type)].kind;
    const char* const card = kind == InpType::Kind::mass      ? "MASS"
                             : kind == InpType::Kind::inertia ? "ROTARY INERTIA"
                             : kind == InpType::Kind::spring_along || kind == InpType::Kind::spring_between
                                 ? "SPRING"
                                 : nullptr;
    if (card && !have[k])
      throw InputError({model.lines.file().name(), 0, 0},
                       fmt::format("element {} has no *{} that gives its value", element.label, card));
  }
}

}  // namespace

void finish_inp_points(const InpModel& model, SolidMesh& mesh) {
  std::vector<char> have(model.elements.size(), 0);
  for (const InpPointProperty& property : model.point_properties)
    for (const int index : model.known_element_set(property.element_set, property.mark).elements) {
      const InpElement& element = model.elements[static_cast<std::size_t>(index)];
      have[static_cast<std::size_t>(index)] = 1;
      const InpType::Kind kind = model.types[static_cast<std::size_t>(element.type)].kind;
      const int* const nodes = model.element_nodes.data() + element.first;
      const std::string name = fmt::format("element {}", element.label);
      const auto require = [&](bool fits, const char* card) {
        if (!fits)
          throw InputError(property.mark, fmt::format("element {} of the set {} is none for *{}",
                                                      element.label, shown(property.element_set), card));
      };
      if (property.kind == PointKind::mass) {
        require(kind == InpType::Kind::mass, "MASS");
        mesh.point_masses.push_back({name, nodes[0], property.values[0]});
      } else if (property.kind == PointKind::inertia) {
        require(kind == InpType::Kind::inertia, "ROTARY INERTIA");
        const auto& v = property.values;
        PointMass point{name, nodes[0]};
        point.inertia << v[0], v[3], v[4], v[3], v[1], v[5], v[4], v[5], v[2];
        mesh.point_masses.push_back(std::move(point));
      } else if (kind == InpType::Kind::spring_between) {
        mesh.springs.push_back(
            {name,
             property.values[0],
             {{nodes[0], property.directions[0], 1}, {nodes[1], property.directions[1], -1}}});
      } else {
        require(kind == InpType::Kind::spring_along, "SPRING");
        const Eigen::Vector3d line = mesh.nodes.col(nodes[1]) - mesh.nodes.col(nodes[0]);
        if (!(line.norm() > 0))
          throw InputError(
              property.mark,
              fmt::format("element {} (SPRINGA) has no length and so no direction", element.label));
        Spring spring{name, property.values[0], {}};
        for (int k = 0; k < 3; ++k) {
          spring.stretch.push_back({nodes[0], k, -line.normalized()[k]});
          spring.stretch.push_back({nodes[1], k, line.normalized()[k]});
        }
        mesh.springs.push_back(std::move(spring));
      }
    }
  require_values(model, have);
}

}  // namespace mimbre::fe
