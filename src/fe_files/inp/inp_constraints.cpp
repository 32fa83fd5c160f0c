#include <fmt/format.h>

#include <algorithm>
#include <set>

#include "fe_files/inp/inp_model.h"
#include "fe_files/text.h"

namespace mimbre::fe {

std::vector<int> inp_nodes(const InpModel& model, std::string_view field) {
  if (const auto label = to_integer(field)) {
    const int node = model.nodes.find(*label);
    return node < 0 ? std::vector<int>{} : std::vector<int>{node};
  }
  std::vector<int> nodes;
  if (const std::vector<int>* set = model.node_sets.find(std::string(field))) nodes = *set;
  std::sort(nodes.begin(), nodes.end());
  nodes.erase(std::unique(nodes.begin(), nodes.end()), nodes.end());
  return nodes;
}

namespace {

std::vector<int> needed_nodes(const InpModel& model, std::string_view field, const Mark& mark) {
  std::vector<int> nodes = inp_nodes(model, field);
  if (nodes.empty()) throw InputError(mark, fmt::format("there is no node or node set '{}'", shown(field)));
  return nodes;
}

int one_node(const InpModel& model, std::string_view field, const Mark& mark) {
  const std::vector<int> nodes = needed_nodes(model, field, mark);
  if (nodes.size() != 1)
    throw InputError(mark, fmt::format("'{}' must be one node, has {}", shown(field), nodes.size()));
  return nodes.front();
}

std::string name_of(const InpKeyword& keyword) {
  return fmt::format("*{} of line {}", keyword.name, keyword.mark.line);
}

/// Nodes of the elements of a set.
std::vector<int> nodes_of_elements(const InpModel& model, const std::string& set, const Mark& mark) {
  std::set<int> nodes;
  for (const int index : model.known_element_set(set, mark).elements) {
    const InpElement& element = model.elements[static_cast<std::size_t>(index)];
    for (int k = 0; k < model.types[static_cast<std::size_t>(element.type)].nodes; ++k)
      nodes.insert(model.element_nodes[element.first + static_cast<std::size_t>(k)]);
  }
  return {nodes.begin(), nodes.end()};
}

/// Only boundary conditions, loads, equations and springs count in its directions; the first two are left
/// out.
void read_transform(InpModel& model, const InpKeyword& keyword) {
  for (const int node : inp_nodes(model, needed(keyword, "NSET"))) model.turned_nodes.insert(node);
  model.warn("keyword TRANSFORM", keyword.mark, "*TRANSFORM is left out");
}

void read_equation(InpModel& model, const InpKeyword& keyword) {
  std::string_view line;
  while (model.lines.next_data(line)) {
    const Mark mark = model.lines.file().mark();
    const auto count = to_integer(next_field(line));
    if (!count || *count < 1 || *count > 1000000)
      model.lines.file().fail("*EQUATION needs the number of its terms first");
    Equation equation{fmt::format("*EQUATION of line {}", mark.line), {}};
    for (std::int64_t k = 0; k < *count; ++k) {
      while (trimmed(line).empty())
        if (!model.lines.next_data(line))
          throw InputError(keyword.mark, fmt::format("*EQUATION has {} of its {} terms", k, *count));
      const int node = one_node(model, next_field(line), model.lines.file().mark());
      const auto direction = to_integer(next_field(line));
      const auto factor = to_real(next_field(line));
      if (!direction || *direction < 1 || *direction > 6 || !factor)
        model.lines.file().fail("a term of *EQUATION is a node, a dof from 1 to 6 and a factor");
      equation.terms.push_back({node, static_cast<int>(*direction) - 1, *factor});
    }
    model.equations.push_back(std::move(equation));
  }
}

void read_rigid_body(InpModel& model, const InpKeyword& keyword) {
  RigidElement rigid;
  rigid.name = name_of(keyword);
  rigid.reference = one_node(model, needed(keyword, "REF NODE"), keyword.mark);
  for (const char* parameter : {"NSET", "TIE NSET", "PIN NSET"})
    if (const std::string* set = keyword.find(parameter)) {
      const auto nodes = needed_nodes(model, *set, keyword.mark);
      rigid.nodes.insert(rigid.nodes.end(), nodes.begin(), nodes.end());
      if (std::string_view(parameter).starts_with("PIN"))
        rigid.follows[3] = rigid.follows[4] = rigid.follows[5] = false;
    }
  if (const std::string* set = keyword.find("ELSET")) {
    const auto nodes = nodes_of_elements(model, *set, keyword.mark);
    rigid.nodes.insert(rigid.nodes.end(), nodes.begin(), nodes.end());
  }
  if (rigid.nodes.empty()) throw InputError(keyword.mark, "*RIGID BODY needs NSET= or ELSET=");
  model.rigid_elements.push_back(std::move(rigid));
}

/// Lines "first dof, last dof"; none: all.
std::array<bool, 6> directions(InpModel& model) {
  std::array<bool, 6> chosen{};
  bool any = false;
  std::string_view line;
  while (model.lines.next_data(line)) {
    const auto first = to_integer(next_field(line));
    const std::string_view field = next_field(line);
    const auto last = field.empty() ? first : to_integer(field);
    if (!first || !last || *first < 1 || *last > 6 || *last < *first)
      model.lines.file().fail("a first and a last dof from 1 to 6 are needed");
    for (auto d = *first; d <= *last; ++d) chosen[static_cast<std::size_t>(d - 1)] = true;
    any = true;
  }
  if (!any) chosen.fill(true);
  return chosen;
}

/// *COUPLING and the *KINEMATIC or *DISTRIBUTING below it.
void read_coupling(InpModel& model, const InpKeyword& keyword) {
  const int reference = one_node(model, needed(keyword, "REF NODE"), keyword.mark);
  const std::vector<int> nodes = needed_nodes(model, needed(keyword, "SURFACE"), keyword.mark);
  if (keyword.find("ORIENTATION")) throw InputError(keyword.mark, "*COUPLING with ORIENTATION is not read");
  InpKeyword kind;
  if (!model.lines.next_keyword(kind) || (kind.name != "KINEMATIC" && kind.name != "DISTRIBUTING"))
    throw InputError(keyword.mark, "*KINEMATIC or *DISTRIBUTING must stand below *COUPLING");
  const std::array<bool, 6> follows = directions(model);
  if (kind.name == "KINEMATIC")
    model.rigid_elements.push_back({name_of(keyword), reference, nodes, follows});
  else
    model.mean_elements.push_back({name_of(keyword), reference, nodes, {}, follows});
}

void read_kinematic_coupling(InpModel& model, const InpKeyword& keyword) {
  const int reference = one_node(model, needed(keyword, "REF NODE"), keyword.mark);
  std::string_view line;
  while (model.lines.next_data(line)) {
    RigidElement rigid{name_of(keyword), reference, {}, {}};
    rigid.nodes = needed_nodes(model, next_field(line), model.lines.file().mark());
    const std::string_view first = next_field(line), last = next_field(line);
    const auto from = first.empty() ? 1 : to_integer(first).value_or(0);
    const auto to = last.empty() ? (first.empty() ? 6 : from) : to_integer(last).value_or(0);
    if (from < 1 || to > 6 || to < from)
      model.lines.file().fail("a node or set, a first and a last dof from 1 to 6 are needed");
    for (auto d = from; d <= to; ++d) rigid.follows[static_cast<std::size_t>(d - 1)] = true;
    model.rigid_elements.push_back(std::move(rigid));
  }
}

void read_distributing_coupling(InpModel& model, const InpKeyword& keyword) {
  MeanElement mean;
  mean.name = name_of(keyword);
  if (const std::string* node = keyword.find("REF NODE")) {
    mean.reference = one_node(model, *node, keyword.mark);
  } else {
    // CalculiX, and Abaqus with an element: its node.
    const auto nodes = nodes_of_elements(model, needed(keyword, "ELSET"), keyword.mark);
    if (nodes.size() != 1)
      throw InputError(keyword.mark, "the ELSET of *DISTRIBUTING COUPLING must have one element of one node");
    mean.reference = nodes.front();
  }
  std::string_view line;
  while (model.lines.next_data(line)) {
    const auto nodes = needed_nodes(model, next_field(line), model.lines.file().mark());
    const std::string_view field = next_field(line);
    const auto weight = field.empty() ? 1.0 : to_real(field).value_or(-1);
    if (!(weight > 0)) model.lines.file().fail("a node or set and a positive weight are needed");
    for (const int node : nodes) {
      mean.nodes.push_back(node);
      mean.weights.push_back(weight);
    }
  }
  if (mean.nodes.empty()) throw InputError(keyword.mark, "*DISTRIBUTING COUPLING has no nodes");
  model.mean_elements.push_back(std::move(mean));
}

void read_mpc(InpModel& model, const InpKeyword& keyword) {
  std::string_view line;
  while (model.lines.next_data(line)) {
    const Mark mark = model.lines.file().mark();
    const std::string type = lower(next_field(line));
    const bool beam = type == "beam", tie = type == "tie", pin = type == "pin";
    if (!beam && !tie && !pin) {
      model.warn("mpc " + type, mark, fmt::format("*MPC {} is left out", shown(type)));
      while (line.ends_with(',') && model.lines.next_data(line)) {
      }
      continue;
    }
    const auto dependent = needed_nodes(model, next_field(line), mark);
    const int reference = one_node(model, next_field(line), mark);
    RigidElement rigid{fmt::format("*MPC of line {}", mark.line), reference, dependent, {}};
    rigid.follows.fill(true);
    if (pin) rigid.follows[3] = rigid.follows[4] = rigid.follows[5] = false;
    model.rigid_elements.push_back(std::move(rigid));
  }
  static_cast<void>(keyword);
}

void read_tie(InpModel& model, const InpKeyword& keyword) {
  if (keyword.find("CYCLIC SYMMETRY") || keyword.find("MULTISTAGE"))
    throw InputError(keyword.mark, "a *TIE of cyclic symmetry is not read: the body must be whole");
  InpTie tie;
  tie.mark = keyword.mark;
  if (const std::string* tolerance = keyword.find("POSITION TOLERANCE")) {
    const auto value = to_real(*tolerance);
    if (!value || !(*value >= 0))
      throw InputError(keyword.mark, fmt::format("POSITION TOLERANCE={} is no length", shown(*tolerance)));
    tie.tolerance = *value;
  }
  std::string_view line;
  while (model.lines.next_data(line)) {
    tie.slave = next_field(line);
    tie.master = next_field(line);
    if (tie.slave.empty() || tie.master.empty())
      model.lines.file().fail("*TIE needs a slave surface and a master surface");
    model.ties.push_back(tie);
  }
}

}  // namespace

bool read_inp_constraint(InpModel& model, const InpKeyword& keyword) {
  if (keyword.name == "EQUATION")
    read_equation(model, keyword);
  else if (keyword.name == "TRANSFORM")
    read_transform(model, keyword);
  else if (keyword.name == "RIGID BODY")
    read_rigid_body(model, keyword);
  else if (keyword.name == "COUPLING")
    read_coupling(model, keyword);
  else if (keyword.name == "KINEMATIC COUPLING")
    read_kinematic_coupling(model, keyword);
  else if (keyword.name == "DISTRIBUTING COUPLING")
    read_distributing_coupling(model, keyword);
  else if (keyword.name == "MPC")
    read_mpc(model, keyword);
  else if (keyword.name == "TIE")
    read_tie(model, keyword);
  else
    return false;
  return true;
}

void check_inp_transforms(const InpModel& model, const SolidMesh& mesh) {
  const auto check = [&](const std::string& name, const std::vector<LinearTerm>& terms) {
    for (const LinearTerm& term : terms)
      if (model.turned_nodes.contains(term.node))
        throw InputError(
            {model.lines.file().name(), 0, 0},
            fmt::format("{} has a dof of node {}, whose directions *TRANSFORM turns; that is not read", name,
                        mesh.labels[static_cast<std::size_t>(term.node)]));
  };
  for (const Equation& equation : mesh.equations)
    if (equation.name.starts_with("*EQUATION")) check(equation.name, equation.terms);
  for (const Spring& spring : mesh.springs)
    if (spring.stretch.size() == 2) check(spring.name, spring.stretch);
}

}  // namespace mimbre::fe
