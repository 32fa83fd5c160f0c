#include <algorithm>

#include "portable/fmu/terminals.h"
#include "portable/fmu/xml.h"

namespace mimbre::portable {
namespace {

/// Half of the icon's edge, in the units of its coordinate system.
constexpr double icon_half = 100;

/// Terminals at one edge of the icon, from the top down.
class Edge {
 public:
  Edge(double x, std::size_t terminals)
      : x_(x), pitch_(2 * icon_half / static_cast<double>(std::max<std::size_t>(terminals, 1))) {}

  void place(pugi::xml_node terminal) {
    const double y = icon_half - pitch_ * (static_cast<double>(next_++) + 0.5),
                 size = std::min(10.0, 0.4 * pitch_);
    pugi::xml_node shown = terminal.append_child("TerminalGraphicalRepresentation");
    set(shown, "defaultConnectionColor", "31 78 121");
    set(shown, "defaultConnectionStrokeSize", 1.0);
    set(shown, "x1", x_ - size);
    set(shown, "y1", y - size);
    set(shown, "x2", x_ + size);
    set(shown, "y2", y + size);
    set(shown, "iconBaseName", "terminal");
  }

 private:
  double x_, pitch_;
  int next_ = 0;
};

pugi::xml_node add_terminal(pugi::xml_node list, const Terminal& t) {
  pugi::xml_node node = list.append_child("Terminal");
  set(node, "name", one_line(t.name));
  set(node, "matchingRule", t.rule);
  set(node, "terminalKind", t.kind);
  set(node, "description", one_line(t.meaning));
  for (const auto& [name, variable] : t.members) {
    pugi::xml_node member = node.append_child("TerminalMemberVariable");
    set(member, "variableName", one_line(variable));
    set(member, "memberName", one_line(name));
    set(member, "variableKind", "signal");
  }
  for (const Terminal& inner : t.inner) add_terminal(node, inner);
  return node;
}

}  // namespace

std::string terminals_description(const std::vector<Terminal>& terminals) {
  pugi::xml_document document;
  pugi::xml_node root = begin_xml(document, "fmiTerminalsAndIcons");
  set(root, "fmiVersion", "3.0");
  pugi::xml_node shown = root.append_child("GraphicalRepresentation");
  const auto square = [&](const char* name) {
    pugi::xml_node node = shown.append_child(name);
    for (const char* low : {"x1", "y1"}) set(node, low, -icon_half);
    for (const char* high : {"x2", "y2"}) set(node, high, icon_half);
    return node;
  };
  pugi::xml_node system = square("CoordinateSystem");
  set(system, "suggestedScalingFactorTo_mm", 0.1);
  square("Icon");
  if (terminals.empty()) return text_of(document);
  const auto taking = static_cast<std::size_t>(
      std::count_if(terminals.begin(), terminals.end(), [](const Terminal& t) { return t.takes; }));
  Edge left(-icon_half, taking), right(icon_half, terminals.size() - taking);
  pugi::xml_node list = root.append_child("Terminals");
  for (const Terminal& t : terminals) (t.takes ? left : right).place(add_terminal(list, t));
  return text_of(document);
}

}  // namespace mimbre::portable
