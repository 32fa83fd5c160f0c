#include "portable/write_tables.h"

#include <fmt/format.h>

#include "compile/compiled.h"
#include "portable/program.h"
#include "portable/texts.h"
#include "signals/blocks/noise.h"
#include "signals/blocks/table_2d.h"

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

std::string mesh_tables(const std::string& name, const std::string& at, const TriangleMesh& mesh) {
  std::vector<double> vertices, normals, boxes;
  std::vector<int> triangles, neighbours, nodes;
  for (const Vec3d& x : mesh.vertices) vertices.insert(vertices.end(), x.data(), x.data() + 3);
  for (const Vec3d& x : mesh.vertex_normals) normals.insert(normals.end(), x.data(), x.data() + 3);
  for (const std::array<int, 3>& t : mesh.triangles) triangles.insert(triangles.end(), t.begin(), t.end());
  for (const std::array<int, 3>& t : mesh.neighbours) neighbours.insert(neighbours.end(), t.begin(), t.end());
  for (const TriangleMesh::Node& n : mesh.nodes) {
    boxes.insert(boxes.end(), n.low.data(), n.low.data() + 3);
    boxes.insert(boxes.end(), n.high.data(), n.high.data() + 3);
    nodes.insert(nodes.end(), {n.first, n.count});
  }
  return table(at + "_vertices", vertices) + table(at + "_normals", normals) + table(at + "_boxes", boxes) +
         table(at + "_triangles", triangles) + table(at + "_neighbours", neighbours) +
         table(at + "_nodes", nodes) +
         fmt::format(
             "static const {0}_mesh {1} = {{{1}_vertices, {1}_normals, {1}_boxes, {1}_triangles, "
             "{1}_neighbours, {1}_nodes}};\n",
             name, at);
}

std::string friction_text(const RoadData& road) {
  std::string out = fmt::format("  out[3] = {};\n", literal(road.friction));
  for (const RoadData::Patch& p : road.patches)
    out += fmt::format("  if (x >= {} && x <= {} && y >= {} && y <= {}) out[3] = {};\n", literal(p.low[0]),
                       literal(p.high[0]), literal(p.low[1]), literal(p.high[1]), literal(p.friction));
  return out;
}

/// What phases call, and the functions that all such calls share.
class Callees {
 public:
  explicit Callees(const std::string& name) : name_(name) {}

  /// Functions `of_call_0`, `of_call_1`, …: what the recording calls.
  void write(const Recording& recording, const std::string& of) {
    const auto& all = recording.callees();
    for (std::size_t k = 0; k < all.size(); ++k) {
      const std::string call = fmt::format("{}_call_{}", of, k), at = fmt::format("{}_table_{}", of, k);
      switch (static_cast<RecordedCallee>(all[k].kind)) {
        case RecordedCallee::function:
          functions_ = true;
          calls_ += pieces_tables(name_, at, *static_cast<const FunctionData*>(all[k].data)) +
                    of_one(call, fmt::format("{}_evaluate_pieces(&{}, x, out)", name_, at));
          break;
        case RecordedCallee::antiderivative:
          integrals_ = true;
          calls_ += pieces_tables(name_, at, *static_cast<const FunctionData*>(all[k].data)) +
                    of_one(call, fmt::format("out[0] = {}_integral_of(&{}, x)", name_, at));
          break;
        case RecordedCallee::integral:
          write_integral(*static_cast<const IntegralFunction*>(all[k].data), call, at);
          break;
        case RecordedCallee::road:
          write_road(*static_cast<const RoadData*>(all[k].data), all[k].number, call, at);
          break;
        case RecordedCallee::noise:
          noise_ = true;
          write_noise(static_cast<const double*>(all[k].data), all[k].number, call);
          break;
        case RecordedCallee::table_of_two:
          tables_ = true;
          write_table_of_two(static_cast<const double*>(all[k].data), call, at);
          break;
        case RecordedCallee::mesh:
          meshes_ = true;
          calls_ += mesh_tables(name_, at, *static_cast<const TriangleMesh*>(all[k].data)) +
                    fmt::format(
                        "static void {}(double x, double y, double z, double *out) {{\n"
                        "  {}_touch(&{}, x, y, z, out);\n}}\n\n",
                        call, name_, at);
          break;
      }
    }
  }

  std::string text() const {
    std::string out;
    for (const auto& [what, there] : {std::pair("FUNCTIONS", functions_), std::pair("INTEGRALS", integrals_),
                                      std::pair("PROFILES", profiles_), std::pair("FORMULAS", formulas_),
                                      std::pair("GRIDS", grids_), std::pair("ROADS", along_)})
      out += fmt::format("#define {}_{} {}\n", name_, what, there ? 1 : 0);
    if (functions_ || integrals_) out += named(functions_text, name_);
    if (formulas_) out += named(formulas_text, name_);
    if (grids_ || along_) out += named(roads_text, name_);
    if (meshes_) out += named(meshes_text, name_);
    if (tables_) out += named(table_of_two_text, name_);
    if (noise_) out += named(noise_text, name_);
    return out + "\n" + calls_;
  }

 private:
  static std::string of_one(const std::string& call, const std::string& made) {
    return fmt::format("static void {}(double x, double *out) {{\n  {};\n}}\n\n", call, made);
  }

  /// The function under the integral is recorded for itself.
  void write_integral(const IntegralFunction& f, const std::string& call, const std::string& at) {
    const std::string under = call + "_under";
    Recording recording;
    const Recorded value = value_at(f.f.front(), Recorded::input(0, 0));
    write(recording, under);
    const IntegralTable::Arrays table_of = f.table.arrays();
    formulas_ = true;
    calls_ += table(at + "_edges", numbers(table_of.edges)) +
              table(at + "_values", numbers(table_of.values)) + write_function(recording, value, under) +
              of_one(call, fmt::format("out[0] = {0}_integral_of_formula({1}_edges, {1}_values, {2}, {3}, x)",
                                       name_, at, table_of.edges.size() - 1, under));
  }

  void write_road(const RoadData& road, double footprint, const std::string& call, const std::string& at) {
    const bool profile = road.over == spec::Road::Over::distance;
    if (profile)
      functions_ = integrals_ = profiles_ = true;
    else
      (road.along_line() ? along_ : grids_) = true;
    calls_ += profile ? pieces_tables(name_, at, road.height) : grid_tables(name_, at, road);
    calls_ += fmt::format("static void {}(double x, double y, double *out) {{\n", call);
    if (profile)
      calls_ += fmt::format("  {}_profile(&{}, {}, x, out);\n", name_, at, literal(footprint));
    else
      calls_ +=
          fmt::format("  {}_{}_height(&{}, x, y, out);\n", name_, road.along_line() ? "road" : "grid", at);
    calls_ += friction_text(road) + "  (void)y;\n}\n\n";
  }

  void write_table_of_two(const double* numbers, const std::string& call, const std::string& at) {
    namespace table_2d = blocks::table_2d;
    const auto x = static_cast<std::ptrdiff_t>(numbers[table_2d::lines_x]),
               y = static_cast<std::ptrdiff_t>(numbers[table_2d::lines_y]);
    const double* first = numbers + table_2d::first_line;
    calls_ += table(at, std::vector<double>(first, first + x + y + x * y)) +
              fmt::format(
                  "static void {}(double x, double y, double *out) {{\n"
                  "  {}_table_of_two({}, {}, {}, x, y, out);\n}}\n\n",
                  call, name_, at, x, y);
  }

  void write_noise(const double* numbers, double every, const std::string& call) {
    namespace noise = blocks::noise;
    const auto seed = static_cast<std::uint64_t>(numbers[noise::seed]);
    calls_ += fmt::format(
        "static void {0}(double x, double *out) {{\n"
        "  out[0] = {1} + {2}*{3}_noise({4}ull, {5}, floor(x/{6} + 1e-6));\n}}\n\n",
        call, literal(numbers[noise::mean]), literal(numbers[noise::deviation]), name_, seed,
        numbers[noise::uniform] > 0.5 ? 1 : 0, literal(every));
  }

  const std::string name_;
  bool functions_ = false, integrals_ = false, profiles_ = false, formulas_ = false, grids_ = false,
       along_ = false, meshes_ = false, noise_ = false, tables_ = false;
  std::string calls_;
};

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
  Callees callees(name);
  callees.write(recording, name);
  return callees.text();
}

}  // namespace mimbre::portable
