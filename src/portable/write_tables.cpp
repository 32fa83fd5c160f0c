#include "portable/write_tables.h"

#include <fmt/format.h>

#include "compile/compiled.h"
#include "portable/program.h"
#include "portable/texts.h"

namespace mimbre::portable {
namespace {

template <class Values, class Text>
std::string array(const char* type, const std::string& name, const Values& values, const Text& text) {
  std::string out = fmt::format("static const {} {}[] = {{", type, name);
  std::size_t column = out.size();
  bool first = true;
  for (const auto& x : values) {
    std::string item = text(x);
    if (!first) out += ',';
    if (column + item.size() > 110) {
      out += "\n ";
      column = 1;
    }
    out += (first ? "" : " ") + item;
    column += item.size() + 2;
    first = false;
  }
  if (first) out += '0';
  return out + "};\n";
}

template <class Values>
std::vector<double> numbers(const Values& values) {
  return {values.begin(), values.end()};
}

/// The tables of polynomial pieces, and the struct that points to them.
std::string pieces_tables(const std::string& name, const std::string& at, const FunctionData& f) {
  if (f.is_zero() || !f.pieces())
    throw NotRecordable(
        "has a function that code cannot look up, such as a road by a formula: give it by points");
  const Pieces::Arrays p = f.pieces()->arrays();
  std::string out = table(at + "_breaks", numbers(p.breaks)) + table(at + "_origins", numbers(p.origins)) +
                    table(at + "_coefficients", numbers(p.coefficients)) +
                    table(at + "_integrals", numbers(p.integral_at_origin));
  out += table(at + "_first", std::vector<int>(p.first.begin(), p.first.end()));
  return out + fmt::format(
                   "static const {0}_pieces {1} = {{{2}, {1}_breaks, {1}_origins, {1}_coefficients, "
                   "{1}_integrals, {1}_first, {3}, {4}, {5}, {6}}};\n",
                   name, at, p.breaks.size(), literal(p.wrap.start), literal(p.wrap.period),
                   literal(p.wrap.integral), literal(p.integral_at_zero));
}

std::string grid_tables(const std::string& name, const std::string& at, const RoadData& road) {
  if (!road.along_line())
    return table(at + "_heights", numbers(road.heights)) +
           fmt::format("static const {0}_grid {1} = {{{{{2}, {3}}}, {{{4}, {5}}}, {6}, {7}, {1}_heights}};\n",
                       name, at, literal(road.origin[0]), literal(road.origin[1]), literal(road.spacing[0]),
                       literal(road.spacing[1]), road.rows, road.columns);
  const roads::GridArrays& g = road.own;
  std::vector<double> circles;
  for (const roads::SegmentCircle& c : g.circles)
    circles.insert(circles.end(),
                   {c.x, c.y, c.radius, static_cast<double>(c.first), static_cast<double>(c.count)});
  return table(at + "_line", numbers(g.line)) + table(at + "_circles", circles) +
         table(at + "_v", numbers(g.v)) + table(at + "_height", numbers(g.height)) +
         table(at + "_along", numbers(g.rounding_along)) + table(at + "_across", numbers(g.rounding_across)) +
         fmt::format(
             "static const {0}_road {1} = {{{2}, {3}, {4}, {1}_line, {1}_circles, {1}_v, {1}_height, "
             "{1}_along, "
             "{1}_across}};\n",
             name, at, roads::grid::points(g), g.v.size(), g.closed);
}

std::string friction_text(const RoadData& road) {
  std::string out = fmt::format("  out[3] = {};\n", literal(road.friction));
  for (const RoadData::Patch& p : road.patches)
    out += fmt::format("  if (x >= {} && x <= {} && y >= {} && y <= {}) out[3] = {};\n", literal(p.low[0]),
                       literal(p.high[0]), literal(p.low[1]), literal(p.high[1]), literal(p.friction));
  return out;
}

}  // namespace

std::string table(const std::string& name, const std::vector<double>& values) {
  return array("double", name, values, [](double x) { return literal(x); });
}
std::string table(const std::string& name, const std::vector<int>& values) {
  return array("int", name, values, [](int x) { return fmt::format("{}", x); });
}

std::string named(const std::string& text, const std::string& name) {
  std::string out;
  for (const char c : text)
    if (c == '@')
      out += name;
    else
      out += c;
  return out;
}

std::string write_callees(const Recording& recording, const std::string& name) {
  bool functions = false, integrals = false, profiles = false, grids = false, along = false;
  std::string calls;
  const auto& all = recording.callees();
  for (std::size_t k = 0; k < all.size(); ++k) {
    const Recording::Callee& callee = all[k];
    const std::string at = fmt::format("{}_table_{}", name, k);
    if (callee.kind != static_cast<int>(RecordedCallee::road)) {
      const FunctionData& f = *static_cast<const FunctionData*>(callee.data);
      const bool integral = callee.kind == static_cast<int>(RecordedCallee::antiderivative);
      (integral ? integrals : functions) = true;
      calls += pieces_tables(name, at, f);
      calls += fmt::format("static void {}_call_{}(double x, double *out) {{\n", name, k);
      calls += integral ? fmt::format("  out[0] = {}_integral_of(&{}, x);\n}}\n\n", name, at)
                        : fmt::format("  {}_evaluate_pieces(&{}, x, out);\n}}\n\n", name, at);
      continue;
    }
    const RoadData& road = *static_cast<const RoadData*>(callee.data);
    const bool profile = road.over == spec::Road::Over::distance;
    if (profile)
      functions = integrals = profiles = true;
    else
      (road.along_line() ? along : grids) = true;
    calls += profile ? pieces_tables(name, at, road.height) : grid_tables(name, at, road);
    calls += fmt::format("static void {}_call_{}(double x, double y, double *out) {{\n", name, k);
    if (profile)
      calls += fmt::format("  {}_profile(&{}, {}, x, out);\n", name, at, literal(callee.number));
    else
      calls +=
          fmt::format("  {}_{}_height(&{}, x, y, out);\n", name, road.along_line() ? "road" : "grid", at);
    calls += friction_text(road) + "  (void)y;\n}\n\n";
  }
  std::string out;
  for (const auto& [what, there] :
       {std::pair("FUNCTIONS", functions), std::pair("INTEGRALS", integrals), std::pair("PROFILES", profiles),
        std::pair("GRIDS", grids), std::pair("ROADS", along)})
    out += fmt::format("#define {}_{} {}\n", name, what, there ? 1 : 0);
  if (functions || integrals) out += named(functions_text, name);
  if (grids || along) out += named(roads_text, name);
  return out + "\n" + calls;
}

}  // namespace mimbre::portable
