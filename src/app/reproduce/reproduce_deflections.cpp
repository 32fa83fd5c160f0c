#include <fmt/format.h>

#include "app/reproduce/reproduce_rows.h"

/// The tables of U. Lugrís' doctoral thesis (Universidade da Coruña, 2008), chapter 4: the spin-up beam.
namespace mimbre::app {
namespace {

const std::string in_plane = "spin-up-beam/beam-2d.yaml", in_space = "spin-up-beam/beam-3d.yaml";

struct DeflectionColumn {
  std::string name;
  Settings settings;
  bool damped = false;  ///< by the default integrator: the trapezoidal rule fails, see the note
};

DeflectionColumn substructures(int count, const std::string& name, const std::string& rotation) {
  return {name,
          {{"method", "substructuring"},
           {"substructures", fmt::format("{}", count)},
           {"boundary_rotation", rotation}}};
}

/// The second axial mode of the first nonlinear stiffness rings with the trapezoidal rule.
DeflectionColumn nonlinear(int axial_modes, const std::string& end) {
  return {fmt::format("{} axial", axial_modes),
          {{"method", "nonlinear_stiffness_1"},
           {"axial_modes", fmt::format("{}", axial_modes)},
           {"axial_end", end}},
          axial_modes > 1};
}

DeflectionColumn foreshortening(int axial_modes) {
  return {fmt::format("{} axial", axial_modes),
          {{"method", "foreshortening"}, {"axial_modes", fmt::format("{}", axial_modes)}}};
}

Case make_case(const std::string& file, const DeflectionColumn& column, Formulation formulation) {
  Case c{file, column.settings, {}};
  c.options.step = 0.01;
  c.options.formulation = formulation;
  if (!column.damped) {
    c.options.integrator = spec::Simulation::Integrator::newmark;
    c.options.xi = 0;
    c.options.substeps = 1;
  }
  return c;
}

/// Published numbers of one formulation, one per column; empty: none.
struct Measured {
  Numbers cpu;
  std::array<Numbers, 3> deviation;  ///< mm, x, y, z
};

PublishedTable spin_up(const std::string& name, const std::string& title, const std::string& file,
                       const std::vector<DeflectionColumn>& columns, const Measured& natural,
                       const Measured& relative) {
  const auto make = [=](Lab& lab, const Report& report) {
    Rows rows(report);
    const auto published = [](const Numbers& numbers, std::size_t k) {
      return k < numbers.size() ? numbers[k] : std::nullopt;
    };
    for (const Formulation formulation : formulations) {
      const Measured& known = formulation == Formulation::natural ? natural : relative;
      const auto note = [&](const DeflectionColumn& column) {
        return column.damped ? "default integrator" : std::string();
      };
      for (std::size_t k = 0; k < columns.size(); ++k)
        rows.add({"CPU, " + formulation_name(formulation),
                  columns[k].name,
                  "s",
                  published(known.cpu, k),
                  {},
                  note(columns[k])},
                 [&](ReproducedRow&) { return lab.cpu_seconds(make_case(file, columns[k], formulation)); });
      for (int component = 0; component < (file == in_plane ? 2 : 3); ++component)
        for (std::size_t k = 0; k < columns.size(); ++k)
          rows.add({fmt::format("{}, {}", "xyz"[component], formulation_name(formulation)),
                    columns[k].name,
                    "mm",
                    published(known.deviation[static_cast<std::size_t>(component)], k),
                    {},
                    note(columns[k])},
                   [&](ReproducedRow&) {
                     return 1e3 * lab.tip_deviation(make_case(file, columns[k], formulation))[component];
                   });
    }
    return rows.take();
  };
  return {name, title, make};
}

}  // namespace

std::vector<PublishedTable> deflection_tables() {
  const DeflectionColumn two_d_foreshortening{"foreshortening",
                                              {{"method", "foreshortening"}, {"axial_modes", "0"}}};
  DeflectionColumn one = nonlinear(1, "held"), two = nonlinear(2, "held");
  one.name = "stiffness, " + one.name;
  two.name = "stiffness, " + two.name;
  std::vector<DeflectionColumn> cuts;
  for (const int count : {3, 5, 10, 20})
    cuts.push_back(substructures(count, fmt::format("{}", count), "exponential"));
  cuts.push_back(substructures(20, "20, infinitesimal", "infinitesimal"));
  return {
      spin_up("spin-up-plane", "Spin-up beam in the plane: CPU time, and mean deviation of the tip (4.1)",
              in_plane, {one, two, two_d_foreshortening}, {{0.266, 0.297, 0.266}, {}},
              {{0.094, 0.125, 0.094}, {}}),
      spin_up("spin-up-substructures", "Spin-up beam in space, by number of substructures (4.2)", in_space,
              cuts, {},
              {{0.375, 0.609, 1.312, 4.578, 4.562},
               {{{3.734, 1.337, 0.502, 0.320, 3.061},
                 {47.681, 13.128, 3.193, 1.481, 1.757},
                 {38.458, 11.682, 2.329, 0.742, 0.920}}}}),
      spin_up("spin-up-stiffness", "Spin-up beam in space, first nonlinear stiffness, by axial modes (4.3)",
              in_space, {nonlinear(1, "free"), nonlinear(2, "free")},
              {{0.271, 0.286}, {{{27.943, 27.946}, {11.046, 5.937}, {7.709, 3.844}}}},
              {{0.105, 0.125}, {{{27.944, 27.947}, {10.313, 5.576}, {7.502, 3.907}}}}),
      spin_up(
          "spin-up-foreshortening", "Spin-up beam in space, foreshortening, by axial modes (4.4)", in_space,
          {foreshortening(0), foreshortening(1), foreshortening(2)},
          {{0.250, 0.292, 0.328}, {{{0.503, 0.360, 0.363}, {3.128, 3.116, 3.116}, {4.780, 4.786, 4.786}}}},
          {{0.105, 0.125, 0.125}, {{{0.496, 0.363, 0.366}, {3.152, 3.149, 3.149}, {4.811, 4.818, 4.818}}}}),
  };
}

}  // namespace mimbre::app
