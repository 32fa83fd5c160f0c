#include "integrate/global_modes/loops.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>

namespace mimbre::global_modes {

namespace {

/// Of what an equation sees of a coordinate, by their scales: less is round-off.
constexpr double redundant = 1e-7;

/// Sets that are joined: each element knows one of its set.
class Sets {
 public:
  explicit Sets(int count) : of_(static_cast<std::size_t>(count)) { std::iota(of_.begin(), of_.end(), 0); }
  int find(int k) {
    while (at(k) != k) k = at(k) = at(at(k));
    return k;
  }
  void join(int a, int b) { at(find(a)) = find(b); }

 private:
  int& at(int k) { return of_[static_cast<std::size_t>(k)]; }
  std::vector<int> of_;
};

}  // namespace

LoopsAndDrives find_loops(const System& system, const CoordinateKinds& kinds) {
  using Kind = CoordinateKinds::Kind;
  std::map<int, std::vector<JacobianEntry>> by_equation;
  for (const JacobianEntry& e : system.jacobian_entries()) by_equation[e.equation].push_back(e);
  LoopsAndDrives out;
  Sets sets(system.velocities());
  std::vector<char> joined(static_cast<std::size_t>(system.velocities()), 0);
  const Scales& scales = system.scales();
  const auto is_drive = [&](int equation) {
    return std::find(kinds.drives.begin(), kinds.drives.end(), equation) != kinds.drives.end();
  };
  const auto kind_of = [&](int k) { return kinds.kind[static_cast<std::size_t>(k)]; };
  for (const auto& [equation, entries] : by_equation) {
    if (entries.size() == 1) {
      const JacobianEntry& e = entries[0];
      const double size = std::abs(e.value) * scales.coordinates[static_cast<std::size_t>(e.coordinate)] /
                          scales.equations[static_cast<std::size_t>(equation)];
      if (size < redundant) continue;  // whether it holds shows at the end of each step
      if (!is_drive(equation) || kind_of(e.coordinate) != Kind::plain)
        throw NoGlobalModes("a constraint holds the only coordinate that it sees; make the joint fixed",
                            e.coordinate);
      if (std::any_of(out.prescribed.begin(), out.prescribed.end(),
                      [&](const Prescribed& p) { return p.coordinate == e.coordinate; }))
        throw NoGlobalModes("two drives move it", e.coordinate);
      out.prescribed.push_back({e.coordinate, equation, e.value});
      continue;
    }
    for (const JacobianEntry& e : entries) {
      sets.join(entries.front().coordinate, e.coordinate);
      joined[static_cast<std::size_t>(e.coordinate)] = 1;
    }
  }
  // The three coordinates of a rotation belong together.
  for (int k = 0; k + 1 < system.velocities(); ++k)
    if (kind_of(k) == Kind::rotation && kind_of(k + 1) == Kind::rotation &&
        kinds.position[static_cast<std::size_t>(k)] == kinds.position[static_cast<std::size_t>(k) + 1] &&
        (joined[static_cast<std::size_t>(k)] || joined[static_cast<std::size_t>(k) + 1])) {
      sets.join(k, k + 1);
      joined[static_cast<std::size_t>(k)] = joined[static_cast<std::size_t>(k) + 1] = 1;
    }
  std::map<int, std::size_t> loop_of;
  for (int k = 0; k < system.velocities(); ++k) {
    if (!joined[static_cast<std::size_t>(k)]) continue;
    const auto [at, is_new] = loop_of.try_emplace(sets.find(k), out.loops.size());
    if (is_new) out.loops.emplace_back();
    Loop& loop = out.loops[at->second];
    (kind_of(k) == Kind::amplitude ? loop.amplitudes : loop.rigid).push_back(k);
  }
  for (const auto& [equation, entries] : by_equation)
    if (entries.size() > 1)
      out.loops[loop_of.at(sets.find(entries.front().coordinate))].equations.push_back(equation);
  for (const Prescribed& p : out.prescribed) {
    if (!joined[static_cast<std::size_t>(p.coordinate)]) continue;
    Loop& loop = out.loops[loop_of.at(sets.find(p.coordinate))];
    if (loop.prescribed >= 0)
      throw NoGlobalModes("two drives move one loop; only loops that can move in one way have a table",
                          p.coordinate);
    loop.prescribed = p.coordinate;
  }
  return out;
}

}  // namespace mimbre::global_modes
