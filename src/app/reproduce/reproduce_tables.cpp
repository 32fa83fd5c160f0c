#include "app/reproduce/reproduce_tables.h"

#include <fmt/format.h>

#include <array>
#include <stdexcept>

#include "app/reproduce/reproduce_rows.h"

/// The tables of U. Lugrís' doctoral thesis (Universidade da Coruña, 2008), chapters 2 and 3; chapter 4 is in
/// reproduce_deflections.cpp, the bases of chapter 1 in reproduce_bases.cpp.
namespace mimbre::app {
namespace {

using Inertia = spec::Simulation::Inertia;
using Integrator = spec::Simulation::Integrator;

// The models.

/// A model with some of its bodies flexible, as a column of a table.
struct Variant {
  std::string column, file;
  Settings settings;
};

std::vector<Variant> bars() {
  std::vector<Variant> variants;
  for (int flexible = 0; flexible <= 5; ++flexible)
    variants.push_back({fmt::format("{}", flexible),
                        "double-four-bar/mechanism.yaml",
                        {{"flexible_bars", fmt::format("{}", flexible)}}});
  return variants;
}

/// By flexible arms (A), links (L) and rods (R). Links and rods have mass in all of them.
std::vector<Variant> flexible_sets(const std::string& file) {
  const auto set = [&](const char* column, bool arms, bool links, bool rods) {
    const auto word = [](bool flexible) { return flexible ? "flexible" : "rigid"; };
    return Variant{column, file, {{"arms", word(arms)}, {"links", word(links)}, {"rods", word(rods)}}};
  };
  return {set("none", false, false, false), set("A", true, false, false),  set("L", false, true, false),
          set("R", false, false, true),     set("A+L", true, true, false), set("A+R", true, false, true),
          set("L+R", false, true, true),    set("all", true, true, true)};
}

std::vector<Variant> vehicles() { return flexible_sets("iltis/vehicle.yaml"); }
std::vector<Variant> suspensions() { return flexible_sets("iltis/suspension.yaml"); }

// The integrators.

/// Newmark's rule as published: steps of 10 ms, none of them repeated.
Case newmark(const Variant& variant, Formulation formulation, double xi = 0) {
  Case c{variant.file, variant.settings, {}};
  c.options.step = 0.01;
  c.options.formulation = formulation;
  c.options.integrator = Integrator::newmark;
  c.options.xi = xi;
  c.options.substeps = 1;
  return c;
}

/// The same with the inertia that the published times are of.
Case projected(Case c) {
  c.options.inertia = Inertia::projection;
  return c;
}

/// The program's own choice.
Case by_default(const Variant& variant, Formulation formulation) {
  Case c{variant.file, variant.settings, {}};
  c.options.step = 0.01;
  c.options.formulation = formulation;
  return c;
}

Case with_step(Case c, double step) {
  c.options.step = step;
  return c;
}

// The tables.

/// Published numbers of both formulations, one per variant.
struct Published {
  Numbers natural, relative;
  const Numbers& of(Formulation formulation) const {
    return formulation == Formulation::natural ? natural : relative;
  }
};

PublishedTable coordinates(const std::string& name, const std::string& title,
                           const std::vector<Variant>& variants, const Published& published) {
  return {"coordinates-" + name, title, [=](Lab& lab, const Report& report) {
            Rows rows(report);
            for (const Formulation formulation : formulations)
              for (std::size_t k = 0; k < variants.size(); ++k)
                rows.add({formulation_name(formulation),
                          variants[k].column,
                          "1",
                          published.of(formulation)[k],
                          {},
                          {}},
                         [&](ReproducedRow&) {
                           return lab.counts(newmark(variants[k], formulation)).coordinates;
                         });
            return rows.take();
          }};
}

PublishedTable cpu(const std::string& name, const std::string& title, const std::vector<Variant>& variants,
                   const Published& published, const std::string& unit, double per_second) {
  return {"cpu-" + name, title, [=](Lab& lab, const Report& report) {
            Rows rows(report);
            for (const Formulation formulation : formulations)
              for (std::size_t k = 0; k < variants.size(); ++k)
                rows.add({formulation_name(formulation),
                          variants[k].column,
                          unit,
                          published.of(formulation)[k],
                          {},
                          {}},
                         [&](ReproducedRow&) {
                           return per_second * lab.cpu_seconds(projected(newmark(variants[k], formulation)));
                         });
            rows.add_quotient("natural over relative", "natural", "relative");
            return rows.take();
          }};
}

/// Table 3.1.
std::vector<ReproducedRow> cpu_inertia(Lab& lab, const Report& report) {
  const std::array columns{"5", "10", "50", "100"};
  const std::array<std::array<Numbers, 2>, 2> published{
      {{Numbers{4.19, 4.48, 7.58, 12.59}, Numbers{3.85, 3.85, 3.85, 3.85}},
       {Numbers{1.11, 1.48, 4.32, 8.21}, Numbers{0.79, 0.79, 0.79, 0.79}}}};
  Rows rows(report);
  for (std::size_t f = 0; f < formulations.size(); ++f)
    for (const bool integrals : {false, true})
      for (std::size_t k = 0; k < columns.size(); ++k) {
        Variant variant = vehicles().back();
        variant.settings["elements"] = columns[k];
        Case c = newmark(variant, formulations[f]);
        c.options.inertia = integrals ? Inertia::integrals : Inertia::projection;
        rows.add({formulation_name(formulations[f]) + (integrals ? ", integrals" : ", projection"),
                  columns[k],
                  "s",
                  published[f][integrals ? 1 : 0][k],
                  {},
                  {}},
                 [&](ReproducedRow&) { return lab.cpu_seconds(c); });
      }
  for (const Formulation formulation : formulations) {
    const std::string name = formulation_name(formulation);
    rows.add_quotient(name + ", projection over integrals", name + ", projection", name + ", integrals");
  }
  return rows.take();
}

/// The four columns of Table 2.7.
struct Column {
  std::string name;
  Variant variant;
  Formulation formulation;
};

std::vector<Column> accuracy_columns() {
  std::vector<Column> columns;
  for (const bool flexible : {false, true})
    for (const Formulation formulation : formulations)
      columns.push_back({(flexible ? "flexible " : "rigid ") + formulation_name(formulation),
                         flexible ? vehicles().back() : vehicles().front(), formulation});
  return columns;
}

constexpr double centimetres = 100, milliseconds = 1000;

/// Errors and longest steps; with the default inertia, which does not change them.
std::vector<ReproducedRow> accuracy(Lab& lab, const Report& report) {
  const std::vector<Column> columns = accuracy_columns();
  Rows rows(report);
  const auto series = [&](const std::string& name, const std::string& unit, const Numbers& published,
                          auto&& measure) {
    for (std::size_t k = 0; k < columns.size(); ++k)
      rows.add({name, columns[k].name, unit, published[k], {}, {}},
               [&](ReproducedRow&) { return measure(columns[k]); });
  };
  const auto trapezoidal = [](const Column& c) { return newmark(c.variant, c.formulation); };
  const auto dissipative = [](const Column& c) { return newmark(c.variant, c.formulation, -0.8); };
  const auto own = [](const Column& c) { return by_default(c.variant, c.formulation); };
  const Numbers none(4);

  series("trapezoidal, 10 ms: error", "cm", {2.472, 1.934, 2.224, 2.175},
         [&](const Column& c) { return centimetres * lab.height_error(trapezoidal(c)); });
  series("trapezoidal: longest step", "ms", {34, 44, 14, 44},
         [&](const Column& c) { return milliseconds * lab.longest_step(trapezoidal(c)).step; });
  series("trapezoidal: error with it", "cm", {7.297, 7.303, 3.031, 8.550},
         [&](const Column& c) { return centimetres * lab.longest_step(trapezoidal(c)).error; });
  series("trapezoidal: none fails up to", "ms", none,
         [&](const Column& c) { return milliseconds * lab.unbroken_step(trapezoidal(c)); });
  series("Newmark, xi -0.8: longest step", "ms", {50, 50, 22, 50},
         [&](const Column& c) { return milliseconds * lab.longest_step(dissipative(c)).step; });
  series("Newmark, xi -0.8: error with it", "cm", {9.301, 9.479, 9.989, 9.517},
         [&](const Column& c) { return centimetres * lab.longest_step(dissipative(c)).error; });
  series("default integrator, 10 ms: error", "cm", none,
         [&](const Column& c) { return centimetres * lab.height_error(own(c)); });
  series("default integrator: longest step", "ms", none,
         [&](const Column& c) { return milliseconds * lab.longest_step(own(c)).step; });
  series("default integrator: error with it", "cm", none,
         [&](const Column& c) { return centimetres * lab.longest_step(own(c)).error; });
  return rows.take();
}

/// The real-time ratios of Table 2.7: simulated time over CPU time.
std::vector<ReproducedRow> real_time(Lab& lab, const Report& report) {
  const std::vector<Column> columns = accuracy_columns();
  Rows rows(report);
  const auto ratio = [&](const Case& c) { return 8 / lab.cpu_seconds(c); };
  const auto at_longest = [&](ReproducedRow& row, const Case& c, bool projection) {
    const double step = lab.longest_step(c).step;
    row.note = fmt::format("at {:.0f} ms", milliseconds * step);
    return ratio(with_step(projection ? projected(c) : c, step));
  };
  const auto series = [&](const std::string& name, const Numbers& published, auto&& measure) {
    for (std::size_t k = 0; k < columns.size(); ++k)
      rows.add({name, columns[k].name, "1", published[k], {}, {}},
               [&](ReproducedRow& row) { return measure(row, columns[k]); });
  };
  series("trapezoidal, 10 ms", {6.37, 34.63, 1.78, 5.41}, [&](ReproducedRow&, const Column& c) {
    return ratio(projected(newmark(c.variant, c.formulation)));
  });
  series("trapezoidal, longest step", {13.11, 85.11, 2.07, 13.14}, [&](ReproducedRow& row, const Column& c) {
    return at_longest(row, newmark(c.variant, c.formulation), true);
  });
  series("Newmark, xi -0.8, longest step", {22.28, 126.98, 3.88, 21.33},
         [&](ReproducedRow& row, const Column& c) {
           return at_longest(row, newmark(c.variant, c.formulation, -0.8), true);
         });
  series("default integrator, integrals, 10 ms", Numbers(4),
         [&](ReproducedRow&, const Column& c) { return ratio(by_default(c.variant, c.formulation)); });
  series("default integrator, integrals, longest step", Numbers(4), [&](ReproducedRow& row, const Column& c) {
    return at_longest(row, by_default(c.variant, c.formulation), false);
  });
  return rows.take();
}

std::vector<ReproducedRow> energy(Lab& lab, const Report& report) {
  Rows rows(report);
  const auto series = [&](const std::string& name, const std::vector<Variant>& variants,
                          const Numbers& published, auto&& measure) {
    std::size_t k = 0;
    for (const bool flexible : {false, true})
      for (const Formulation formulation : formulations) {
        const Case c = newmark(flexible ? variants.back() : variants.front(), formulation);
        rows.add({name,
                  (flexible ? "flexible " : "rigid ") + formulation_name(formulation),
                  "J",
                  published[k++],
                  {},
                  {}},
                 [&](ReproducedRow&) { return measure(c); });
      }
  };
  series("double four-bar, mean loss", bars(), {0.021, 0.004, 0.021, 0.018},
         [&](const Case& c) { return lab.mean_energy_loss(c); });
  series("suspension, loss at the end", suspensions(), {15.73, 14.07, 15.45, 15.1},
         [&](const Case& c) { return lab.energy_loss(c); });
  return rows.take();
}

}  // namespace

const std::vector<PublishedTable>& published_tables() {
  static const std::vector<PublishedTable> tables = [] {
    std::vector<PublishedTable> all{
        coordinates("double-four-bar", "Coordinates of the double four-bar, by number of flexible bars (2.1)",
                    bars(), {{6, 13, 20, 27, 34, 41}, {5, 8, 11, 14, 17, 20}}),
        coordinates("suspension", "Coordinates of the suspension, by flexible parts (2.3)", suspensions(),
                    {{35, 45, 47, 50, 57, 60, 62, 72}, {8, 12, 14, 14, 18, 18, 20, 24}}),
        coordinates("vehicle", "Coordinates of the vehicle, by flexible parts (2.5)", vehicles(),
                    {{168, 196, 216, 228, 244, 256, 276, 304}, {34, 50, 58, 58, 74, 74, 82, 98}}),
        cpu("double-four-bar",
            "CPU time of the double four-bar, 5 s, by number of flexible bars (2.2; published in an "
            "interpreter)",
            bars(), {{0.91, 3.30, 6.24, 9.61, 11.51, 15.22}, {4.85, 9.11, 12.62, 15.74, 17.74, 20.92}}, "s",
            1),
        cpu("suspension",
            "CPU time of the suspension, 5 s, by flexible parts (2.4; published in an interpreter)",
            suspensions(), {{45, 155, 120, 91, 234, 231, 175, 298}, {31, 125, 52, 67, 169, 167, 98, 216}},
            "ms", 1000),
        cpu("vehicle", "CPU time of the vehicle, 8 s, by flexible parts (2.6)", vehicles(),
            {{1.25, 2.33, 2.35, 2.41, 3.35, 3.44, 3.31, 4.48},
             {0.23, 0.74, 0.57, 0.58, 1.22, 1.21, 0.93, 1.48}},
            "s", 1),
        {"cpu-inertia", "CPU time of the vehicle, all flexible, by elements per bar and inertia (3.1)",
         cpu_inertia},
        {"accuracy", "Error of the vehicle's chassis height, and longest steps of 10 to 50 ms (2.7)",
         accuracy},
        {"real-time", "Real-time ratio of the vehicle (2.7)", real_time},
        {"energy", "Energy lost by the numerics, trapezoidal rule, 10 ms (2.9.1, 2.9.2)", energy},
    };
    for (const PublishedTable& table : deflection_tables()) all.push_back(table);
    for (const PublishedTable& table : basis_tables()) all.push_back(table);
    return all;
  }();
  return tables;
}

}  // namespace mimbre::app
