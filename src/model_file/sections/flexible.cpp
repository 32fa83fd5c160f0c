#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include "mimbre/reduced_body.h"
#include "model_file/text/builder.h"
#include "spec/nearest_place.h"

/// Frames of beams: `flexible:` of a body, made into a finite-element mesh and the options of its reduction.
namespace mimbre::model_file {
namespace {

/// Of the round bar that a section looks like: a full one of its area, or a thin tube of its second moments.
double drawn_radius(const fe::Section& section) {
  const double full = std::sqrt(section.area / std::numbers::pi);
  return std::max(full, std::sqrt(2 * std::min(section.Iy, section.Iz) / section.area));
}

/// A node that hangs rigidly on a bar, or lies on it.
struct OnBar {
  std::string bar;
  double fraction = 0;
  int node = 0;
  Mark mark;
};

struct Reader {
  Builder& builder;
  const Part& part;
  const Value& value;
  const spec::Pose& pose;
  BodyInfo& info;
  FlexibleDescription result;
  std::vector<OnBar> on_bars;
  std::vector<OnBar> other_names;  ///< of bars' ends; their node is found with the bar, -1 until then
  std::vector<std::pair<int, int>> bar_ends;
  std::vector<bool> used;
  std::vector<Eigen::Vector3d> positions;  ///< of the mesh's nodes, named ones first
  int axial_modes = 0;
  bool good = true;

  void fail(const Value& at, const std::string& message) {
    at.error(message);
    good = false;
  }
  Eigen::Vector3d local_vector(const Eigen::Vector3d& v) const { return pose.rotation.transpose() * v; }

  int find_node(const Value& named) {
    const auto name = named.word();
    if (!name) return fail_quietly();
    const auto found = std::find(info.node_names.begin(), info.node_names.end(), *name);
    if (found != info.node_names.end()) {
      const auto k = static_cast<std::size_t>(found - info.node_names.begin());
      if (k < used.size()) return static_cast<int>(k);
      const OnBar& end = other_names[k - used.size()];
      if (end.node < 0)
        fail(named,
             fmt::format("node '{}' is an end of bar '{}', which comes further down; put that bar first",
                         *name, end.bar));
      return end.node;
    }
    fail(named, fmt::format("there is no node '{}'{}; there are: {}", *name,
                            did_you_mean(*name, info.node_names), joined(info.node_names)));
    return -1;
  }
  int fail_quietly() {
    good = false;
    return -1;
  }

  /// Another name of the node at a bar's end: {on: [front, 1]}.
  bool is_bar_end(const Tree& node) {
    const Tree::Entry* on = node.kind == Tree::Kind::map ? node.find("on") : nullptr;
    if (!on || on->value->kind != Tree::Kind::list || on->value->items.size() != 2) return false;
    const Value fraction(value.reading(), *on->value->items[1], value.what());
    if (!fraction.is_scalar()) return false;
    try {
      const double x = evaluate(fraction.tree().text, *value.reading().scope);
      return x == 0 || x == 1;
    } catch (const ExpressionError&) {
      return false;  // reported where it is read
    }
  }

  void read_bar_end(const std::string& name, const Value& node) {
    const Fields fields(node, {"at", "on"});
    const auto on = fields.get("on")->list();
    const auto bar = on[0].word();
    const auto fraction = on[1].number();
    if (const auto at = fields.get("at"))
      fail(*at, "the end of a bar has its place already; leave it out, or put the node on a bar of its own");
    if (!bar || !fraction) return void(good = false);
    other_names.push_back({*bar, *fraction, -1, on[0].mark()});
    info.node_names.push_back(name);
  }

  void read_nodes(const Value& nodes) {
    if (!nodes.is_map()) return fail(nodes, "names with places are needed, for example tip: [1, 0, 0]");
    std::vector<std::pair<std::string, Value>> ends;
    for (const auto& entry : nodes.tree().entries) {
      if (!check_name(part.reading, entry.key, entry.mark, "node")) {
        good = false;
        continue;
      }
      const Value node(value.reading(), *entry.value, fmt::format("{} '{}'", nodes.what(), entry.key));
      if (is_bar_end(*entry.value)) {
        ends.emplace_back(entry.key, node);
        continue;
      }
      std::optional<Eigen::Vector3d> place;
      if (node.is_list()) {
        place = node.triple(quantity::length);
        good = good && place;
      } else {
        const Fields fields(node, {"at", "on"});
        if (const auto at = fields.get("at")) {
          place = at->triple(quantity::length);
          good = good && place;
        }
        if (const auto on = fields.get("on"))
          read_on_bar(*on);
        else if (!place)
          fail(node, "a place is needed: [x, y, z], or {on: [bar, 0.5]}");
        if (!place) unplaced.push_back(static_cast<int>(info.node_names.size()));
      }
      info.node_names.push_back(entry.key);
      positions.push_back(pose.rotation.transpose() *
                          (part.place.point(place.value_or(Eigen::Vector3d::Zero())) - pose.position));
    }
    used.assign(positions.size(), false);
    for (const auto& [name, node] : ends) read_bar_end(name, node);
    if (positions.empty()) fail(nodes, "there is no node");
  }
  std::vector<int> unplaced;  ///< nodes that are placed by their bar

  void read_on_bar(const Value& on) {
    if (!on.is_list() || on.tree().items.size() != 2)
      return fail(on, "a bar and a part of its length are needed: [front, 0.8]");
    const auto parts = on.list();
    const auto bar = parts[0].word();
    const auto fraction = parts[1].number();
    if (!bar || !fraction) return void(good = false);
    if (*fraction < 0 || *fraction > 1)
      return fail(parts[1], fmt::format("{} is not between 0 and 1, the ends of the bar", *fraction));
    on_bars.push_back({*bar, *fraction, static_cast<int>(info.node_names.size()), on.mark()});
  }

  template <class T>
  const T* find_named(const std::map<std::string, T>& known, const std::string& kind, const Fields& bar,
                      const Fields& body, const std::string& key) {
    auto named = bar.get(key);
    if (!named) named = body.get(key);
    if (!named) {
      fail(bar.value(), fmt::format("'{}' is missing, here and beside 'bars'", key));
      return nullptr;
    }
    const auto name = named->word();
    if (!name) return void(good = false), nullptr;
    const auto found = known.find(*name);
    if (found != known.end()) return &found->second;
    std::vector<std::string> names;
    for (const auto& [n, v] : known) names.push_back(n);
    fail(*named, fmt::format("there is no {} '{}'{}{}", kind, *name, did_you_mean(*name, names),
                             names.empty() ? "" : "; there are: " + joined(names)));
    return nullptr;
  }

  /// The bar's section, with its shear areas where the theory needs them.
  void set_section(fe::BeamElement& element, const NamedSection& named, const Fields& bar,
                   const Fields& body) {
    element.section = named.section;
    auto theory = bar.get("beam_theory");
    if (!theory) theory = body.get("beam_theory");
    if (!theory) return;
    const auto kind = theory->choice({"euler_bernoulli", "rayleigh", "timoshenko"});
    if (!kind) return void(good = false);
    element.theory = static_cast<fe::BeamTheory>(*kind);
    if (element.theory != fe::BeamTheory::timoshenko || element.section.shear_y > 0) return;
    if (!named.shear.known())
      return fail(bar.value(),
                  "has a section without shear areas, which Timoshenko's theory needs; give the section "
                  "shear_areas: [along y, along z]");
    element.section.shear_y = element.section.shear_z =
        named.shear.at(element.material.poisson) * element.section.area;
  }

  void read_bars(const Value& bars, const Fields& body) {
    if (!bars.is_map())
      return fail(bars, "names with bars are needed, for example front: {from: pivot, to: tip}");
    std::vector<std::string> names;
    for (const auto& entry : bars.tree().entries) {
      names.push_back(entry.key);
      const Value bar(value.reading(), *entry.value, fmt::format("{} '{}'", bars.what(), entry.key));
      read_bar(entry.key, bar, body);
    }
    for (const auto* nodes : {&on_bars, &other_names})
      for (const OnBar& on : *nodes)
        if (std::find(names.begin(), names.end(), on.bar) == names.end()) {
          good = false;
          builder.errors.add(on.mark, fmt::format("{}: there is no bar '{}'{}; there are: {}", value.what(),
                                                  on.bar, did_you_mean(on.bar, names), joined(names)));
        }
    if (names.empty()) fail(bars, "there is no bar");
  }

  /// Material, section and axes of a bar's elements.
  fe::BeamElement element_of(const std::string& name, const Fields& bar, const Fields& body) {
    fe::BeamElement element;
    element.bar = name;
    if (const auto* material = find_named(part.materials, "material", bar, body, "material"))
      element.material = *material;
    if (const auto* section = find_named(part.sections, "section", bar, body, "section"))
      set_section(element, *section, bar, body);
    if (const auto y = bar.get("y")) {
      const auto direction = y->direction();
      good = good && direction;
      if (direction) element.y_direction = local_vector(part.place.vector(*direction));
    }
    return element;
  }

  /// A node on a bar; the ends are at 0 and 1.
  struct Stop {
    double fraction;
    int node;
  };

  /// The nodes on a bar, its ends included, in order; places those that it carries. Empty where two coincide.
  std::vector<Stop> stops_on(const std::string& name, int a, int b) {
    const Eigen::Vector3d start = positions[static_cast<std::size_t>(a)],
                          end = positions[static_cast<std::size_t>(b)];
    std::vector<Stop> stops{{0, a}, {1, b}};
    for (const OnBar& on : on_bars)
      if (on.bar == name) {
        stops.push_back({on.fraction, on.node});
        used[static_cast<std::size_t>(on.node)] = true;
        if (std::erase(unplaced, on.node) > 0)
          positions[static_cast<std::size_t>(on.node)] = start + on.fraction * (end - start);
      }
    std::sort(stops.begin(), stops.end(),
              [](const Stop& s, const Stop& t) { return s.fraction < t.fraction; });
    for (std::size_t k = 0; k + 1 < stops.size(); ++k)
      if (stops[k + 1].fraction - stops[k].fraction < 1e-6) return {};

    return stops;
  }

  /// Elements from stop to stop, as equal as these permit; false beyond the limit of their number.
  bool add_elements(fe::BeamElement element, const std::vector<Stop>& stops, int elements) {
    const Eigen::Vector3d start = positions[static_cast<std::size_t>(stops.front().node)],
                          end = positions[static_cast<std::size_t>(stops.back().node)];
    for (std::size_t k = 0; k + 1 < stops.size(); ++k) {
      const Stop &s = stops[k], &t = stops[k + 1];
      const int n = std::max(1, static_cast<int>(std::lround(elements * (t.fraction - s.fraction))));
      if (static_cast<int>(result.mesh.elements.size()) + n > builder.limits.elements) return false;
      int last = s.node;
      for (int i = 1; i <= n; ++i) {
        const auto point_at = [&](int j) -> Eigen::Vector3d {
          return start + (s.fraction + (t.fraction - s.fraction) * j / n) * (end - start);
        };
        int next = t.node;
        if (i < n) {
          next = static_cast<int>(positions.size());
          positions.push_back(point_at(i));
        }
        element.nodes = {last, next};
        const auto offset = [&](int node, int j, bool bar_end) -> Eigen::Vector3d {
          if (bar_end) return Eigen::Vector3d::Zero();
          return point_at(j) - positions[static_cast<std::size_t>(node)];
        };
        element.offsets[0] = offset(last, i - 1, i > 1 || k == 0);
        element.offsets[1] = offset(next, i, i < n || k + 2 == stops.size());
        result.mesh.elements.push_back(element);
        last = next;
      }
    }
    return true;
  }

  void read_bar(const std::string& name, const Value& value_of_bar, const Fields& body) {
    const Fields bar(value_of_bar, {"from", "to", "elements", "section", "material", "beam_theory", "y"});
    const auto from = bar.need("from", "pivot"), to = bar.need("to", "tip");
    const int a = from ? find_node(*from) : fail_quietly(), b = to ? find_node(*to) : fail_quietly();
    const fe::BeamElement element = element_of(name, bar, body);
    int elements = 10;
    if (const auto count = bar.get("elements")) {
      const auto n = count->integer(1, builder.limits.elements);
      good = good && n;
      elements = n.value_or(1);
    }
    if (a < 0 || b < 0) return;
    bar_ends.emplace_back(a, b);
    for (OnBar& end : other_names)
      if (end.bar == name) end.node = end.fraction == 0 ? a : b;
    for (const int node : {a, b})
      if (std::find(unplaced.begin(), unplaced.end(), node) != unplaced.end())
        return fail(value_of_bar,
                    fmt::format("node '{}' lies on a bar that comes further down; put that bar first",
                                info.node_names[static_cast<std::size_t>(node)]));
    used[static_cast<std::size_t>(a)] = used[static_cast<std::size_t>(b)] = true;
    const Eigen::Vector3d start = positions[static_cast<std::size_t>(a)],
                          end = positions[static_cast<std::size_t>(b)];
    const double length = (end - start).norm();
    if (a == b) return fail(value_of_bar, "begins and ends at the same node");
    if (at_one_place(start, end))
      return fail(value_of_bar, "has no length; its two nodes are at the same place");
    if (element.y_direction.cross(end - start).norm() < 1e-6 * length && !element.y_direction.isZero(0))
      return fail(*bar.get("y"), "is along the bar; give a direction across it");
    const std::vector<Stop> stops = stops_on(name, a, b);
    if (stops.empty())
      return fail(value_of_bar, "two nodes are at the same point of it; put one of them on its own bar");
    if (!add_elements(element, stops, elements))
      return fail(value_of_bar, fmt::format("the body has more than {} elements", builder.limits.elements));
    result.line_radius = std::max(result.line_radius, drawn_radius(element.section));
  }

  void read_clamped(const Value& clamped) {
    for (const Value& item : clamped.list())
      if (const int node = find_node(item); node >= 0) result.options.clamped_nodes.push_back(node);
    if (result.options.clamped_nodes.empty() && good)
      fail(clamped, "names no node; a tangent frame holds at least one, for example clamped: [pivot]");
  }

  void read_static_mode(const Value& item) {
    const Fields fields(item, {"node", "along", "about", "all", "name", "when"});
    if (const auto when = fields.get("when")) {
      const auto wanted = when->flag();
      if (!wanted) return void(good = false);
      if (!*wanted) return;
    }
    const auto named = fields.need("node", "tip");
    const int node = named ? find_node(*named) : fail_quietly();
    const auto along = fields.get("along"), about = fields.get("about"), all = fields.get("all");
    if (int(along.has_value()) + int(about.has_value()) + int(all.has_value()) != 1)
      return fail(item, "one of along: [..], about: [..], all: true is needed");
    std::string name;
    if (const auto given = fields.get("name")) name = given->word().value_or("");
    if (node < 0) return;
    const std::string& node_name = info.node_names[static_cast<std::size_t>(node)];
    const auto& held = result.options.clamped_nodes;
    if (std::find(held.begin(), held.end(), node) != held.end())
      return fail(*named, fmt::format("node '{}' is clamped and cannot have a static mode", node_name));
    if (all) {
      if (!all->flag().value_or(true)) return fail(*all, "'all' can only be true");
      for (int k = 0; k < 6; ++k)
        result.options.boundary.push_back(
            {node, k > 2, Eigen::Vector3d::Unit(k % 3),
             fmt::format("{}.{}{}", node_name, k > 2 ? "r" : "", "xyz"[k % 3])});
      return;
    }
    const auto direction = (along ? along : about)->direction();
    if (!direction) return void(good = false);
    const Eigen::Vector3d placed =
        along ? part.place.vector(*direction) : part.place.pseudo_vector(*direction);
    if (name.empty()) name = fmt::format("{}.{}", node_name, result.options.boundary.size() + 1);
    result.options.boundary.push_back({node, about.has_value(), local_vector(placed), name});
  }

  void read_stiffening(const Fields& fields) {
    if (const auto kind = fields.get("stiffening"))
      if (const auto k = kind->choice({"linear", "foreshortening", "nonlinear_stiffness_1",
                                       "nonlinear_stiffness_2", "geometric_stiffness"}))
        result.options.stiffening = static_cast<fe::Stiffening>(*k);
    // Without ⅛∫EA v'⁴ the energy has no lower bound: a beam that follows its gradient collapses.
    result.options.published_force = result.options.stiffening == fe::Stiffening::nonlinear_stiffness_1;
    if (const auto force = fields.get("stiffening_force"))
      result.options.published_force = force->choice({"consistent", "published"}).value_or(0) == 1;
  }

  /// With its end held, the first axial mode is the bar stretched from there and the others keep that end
  /// where it is; with its end free, they are the bar's own.
  void read_axial_modes(const Value& value_of_modes) {
    std::optional<int> n;
    bool free_end = false;
    if (value_of_modes.is_map()) {
      const Fields fields(value_of_modes, {"count", "end"});
      if (const auto count = fields.need("count", "1")) n = count->integer(0, builder.limits.dynamic_modes);
      if (const auto end = fields.get("end")) free_end = end->choice({"held", "free"}).value_or(0) == 1;
    } else {
      n = value_of_modes.integer(0, builder.limits.dynamic_modes);
    }
    good = good && n;
    axial_modes = n.value_or(0);
    if (axial_modes == 0 || !good) return;
    const auto& held = result.options.clamped_nodes;
    const auto refuse = [&](const std::string& what) {
      fail(value_of_modes, "axial modes need one straight bar that is clamped at one of its ends; " + what);
    };
    if (bar_ends.size() != 1) return refuse(fmt::format("this body has {} bars", bar_ends.size()));
    const auto [a, b] = bar_ends.front();
    if (held.size() != 1 || (held.front() != a && held.front() != b))
      return refuse(held.size() == 1 ? "another node is" : "several nodes are");
    if (free_end) return void(result.options.axial_dynamic_modes = *n);
    const int end = held.front() == a ? b : a;
    const Eigen::Vector3d along =
        positions[static_cast<std::size_t>(end)] - positions[static_cast<std::size_t>(held.front())];
    result.options.boundary.push_back(
        {end, false, along.normalized(),
         fmt::format("{}.axial", info.node_names[static_cast<std::size_t>(end)])});
    result.options.axial_dynamic_modes = *n - 1;
  }

  /// One or two axial modes, or a few pieces with a tension each, cannot follow the tension along a beam that
  /// turns.
  void warn_of_few_axial_modes(const Fields& fields) {
    const fe::Stiffening s = result.options.stiffening;
    if (s != fe::Stiffening::nonlinear_stiffness_1 && s != fe::Stiffening::nonlinear_stiffness_2) return;
    if (result.substructures.count > 1) {
      if (result.substructures.count < 5)
        builder.warnings.push_back(
            {result.substructures.mark,
             fmt::format("{}: {} substructures show poorly how the tension varies along a bar, so that the "
                         "frequencies of a turning beam are wrong; 5 are enough for one straight bar",
                         value.what(), result.substructures.count)});
      return;
    }
    if (axial_modes > 2) return;
    const auto at = axial_modes > 0 ? fields.get("axial_modes") : fields.get("stiffening");
    builder.warnings.push_back(
        {at->mark(),
         fmt::format("{}: {} axial mode{} show{} poorly how the tension varies along a bar, so that the "
                     "frequencies of a turning beam are wrong by some percent; axial_modes: 4 are enough for "
                     "one straight bar",
                     value.what(), axial_modes == 0 ? "no" : std::to_string(axial_modes),
                     axial_modes == 1 ? "" : "s", axial_modes == 1 ? "s" : "")});
  }

  void read_substructures(const Value& pieces) {
    Substructures& s = result.substructures;
    s.mark = pieces.mark();
    std::optional<int> count, modes = result.options.dynamic_modes;
    if (pieces.is_map()) {
      const Fields fields(pieces, {"count", "dynamic_modes"});
      if (const auto given = fields.need("count", "5")) count = given->integer(1, builder.limits.elements);
      if (const auto given = fields.get("dynamic_modes"))
        modes = given->integer(0, builder.limits.dynamic_modes);
    } else {
      count = pieces.integer(1, builder.limits.elements);
    }
    good = good && count && modes;
    s.count = count.value_or(1);
    s.dynamic_modes = modes.value_or(0);
    if (s.count > 1 && result.options.axial_dynamic_modes > 0)
      fail(pieces, "'axial_modes' above 1 are for a beam in one piece; the pieces stretch by their brackets");
  }

  void read_planar(const Value& planar) {
    const auto normal = planar.direction();
    if (!normal) return void(good = false);
    Eigen::Index axis = 0;
    const Eigen::Vector3d local = local_vector(part.place.vector(*normal));
    if (local.cwiseAbs().maxCoeff(&axis) < 1 - 1e-6)
      return fail(planar,
                  fmt::format("the normal {} must be along an axis of the body's frame; it is {} there",
                              to_text(*normal), to_text(local)));
    result.normal = Eigen::Vector3d::Unit(axis);
    const auto& held = result.options.clamped_nodes;
    for (int node = 0; node < static_cast<int>(positions.size()); ++node) {
      if (std::find(held.begin(), held.end(), node) != held.end()) continue;
      const int k = static_cast<int>(axis);
      for (const int dof : {k, 3 + (k + 1) % 3, 3 + (k + 2) % 3})
        result.options.fixed_dofs.push_back(6 * node + dof);
    }
  }

  /// Beams of one element per frame have no modes to choose.
  void read_kind(const Value& kind) {
    const auto k = kind.choice(
        {"reduced", "corotational", "ancf", "segments", "stretching_segments", "ancf_cable", "ancf_thick"});
    if (!k || *k == 0) return;
    result.kind = static_cast<BeamKind>(*k);
    fe::ReductionOptions& o = result.options;
    if (!o.boundary.empty() || o.dynamic_modes + o.axial_dynamic_modes > 0 ||
        result.substructures.count > 1 || o.stiffening != fe::Stiffening::linear)
      return fail(kind,
                  "takes all of the elements' motions: leave out static_modes, dynamic_modes, axial_modes, "
                  "substructures and stiffening");
    if (result.kind == BeamKind::corotational) {
      result.substructures = {kind.mark(), static_cast<int>(result.mesh.elements.size()), 0};
      o.stiffening = fe::Stiffening::foreshortening;
    } else if (result.kind == BeamKind::ancf && result.normal.isZero(0)) {
      fail(kind,
           "by absolute nodal coordinates moves in a plane; give its normal, for example planar: [0, 0, 1], "
           "or "
           "take ancf_cable or ancf_thick, which move in space");
    } else if (result.kind != BeamKind::ancf && result.by_ancf() && !result.normal.isZero(0)) {
      fail(kind, "moves in space; leave out 'planar', or take ancf");
    } else if (result.by_ancf() && o.clamped_nodes.size() > 1) {
      fail(kind, "by absolute nodal coordinates is clamped at one end");
    }
  }

  /// Masses are lumped at the nodes of bars whose reduction sums over the mesh.
  void read_mass_matrix(const Value& mass_matrix) {
    if (mass_matrix.choice({"consistent", "lumped"}).value_or(0) == 0) return;
    result.options.mass_matrix = fe::MassMatrix::lumped;
    if (result.by_ancf())
      fail(mass_matrix,
           "cannot be lumped by absolute nodal coordinates, whose mass matrix is constant as it is; take "
           "beam: "
           "reduced or corotational");
    if (result.in_segments())
      fail(mass_matrix,
           "cannot be lumped in segments, which are rigid bodies with inertia of their own; take beam: "
           "reduced "
           "or corotational");
  }

  void read() {
    const Fields fields(value,
                        {"material", "section", "nodes", "bars", "clamped", "static_modes", "dynamic_modes",
                         "stiffness_damping", "planar", "stiffening", "stiffening_force", "axial_modes",
                         "substructures", "beam", "beam_theory", "boundary_rotation", "mass_matrix"});
    result.mark = value.mark();
    result.what = value.what();
    result.line_radius = 0;
    const auto nodes = fields.need("nodes", "{tip: [1, 0, 0]}"),
               bars = fields.need("bars", "{bar: {from: a, to: b}}"),
               clamped = fields.need("clamped", "[pivot]");
    good = value.is_map() && nodes && bars && clamped;
    if (nodes) read_nodes(*nodes);
    if (bars && nodes) read_bars(*bars, fields);
    if (good)
      for (std::size_t k = 0; k < used.size(); ++k)
        if (!used[k])
          fail(*nodes,
               fmt::format("node '{}' is on no bar; give it {{at: .., on: [bar, 0.5]}} or a bar of its own",
                           info.node_names[k]));
    if (clamped && nodes) read_clamped(*clamped);
    if (const auto modes = fields.get("static_modes"))
      for (const Value& mode : modes->list()) read_static_mode(mode);
    if (const auto count = fields.get("dynamic_modes")) {
      const auto n = count->integer(0, builder.limits.dynamic_modes);
      good = good && n;
      result.options.dynamic_modes = n.value_or(0);
    }
    if (const auto damping = fields.get("stiffness_damping")) {
      const auto c = damping->not_negative(quantity::time);
      good = good && c;
      result.options.stiffness_damping = c.value_or(0);
    }
    if (const auto planar = fields.get("planar")) read_planar(*planar);
    read_stiffening(fields);
    if (const auto modes = fields.get("axial_modes")) read_axial_modes(*modes);
    if (const auto pieces = fields.get("substructures")) read_substructures(*pieces);
    warn_of_few_axial_modes(fields);
    if (const auto turning = fields.get("boundary_rotation"))
      if (const auto k = turning->choice({"exponential", "successive", "infinitesimal"}))
        result.options.boundary_rotation = static_cast<BoundaryRotation>(*k);
    if (const auto kind = fields.get("beam")) read_kind(*kind);
    if (const auto mass_matrix = fields.get("mass_matrix")) read_mass_matrix(*mass_matrix);
    if (good && result.kind == BeamKind::reduced && result.substructures.count == 1 &&
        result.options.boundary.empty() && result.options.dynamic_modes == 0)
      fail(value, "has no modes; give static_modes or dynamic_modes");

    result.mesh.nodes.resize(3, static_cast<Eigen::Index>(positions.size()));
    for (std::size_t k = 0; k < positions.size(); ++k)
      result.mesh.nodes.col(static_cast<Eigen::Index>(k)) = positions[k];
    for (std::size_t k = 0; k < info.node_names.size(); ++k) {
      const int node = k < used.size() ? static_cast<int>(k) : std::max(0, other_names[k - used.size()].node);
      info.node_positions.push_back(positions.empty() ? Eigen::Vector3d::Zero()
                                                      : positions[static_cast<std::size_t>(node)]);
      result.frames.push_back({info.node_names[k], node, Eigen::Matrix3d::Identity()});
    }
  }
};

}  // namespace

std::optional<FlexibleDescription> read_flexible(Builder& builder, const Part& part, const Value& value,
                                                 const spec::Pose& pose, BodyInfo& info) {
  Reader reader{builder, part, value, pose, info, {}, {}, {}, {}, {}, {}, 0, true, {}};
  reader.read();
  if (!reader.good) return {};
  return std::move(reader.result);
}

}  // namespace mimbre::model_file
