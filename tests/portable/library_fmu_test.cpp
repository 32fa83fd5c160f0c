#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "mimbre/diagnostics.h"
#include "mimbre/fmu.h"
#include "support/fmu_importer.h"
#include "support/models.h"

/// FMUs with the library inside; what they do as an importer calls them is in
/// python/tests/test_library_fmu.py.
namespace mimbre::test::library_fmu_test {
namespace {

using testing::HasSubstr;

const char* const sliding =
    "bodies: {b: {mass: 2, com: [0, 0, 0], inertia: [1, 1, 1]}}\n"
    "inputs: {push: {unit: N, range: [-9, 9], start: 3}}\n"
    "joints: {j: {type: prismatic, between: [ground, b], at: [0, 0, 0], axis: [0, 0, 1]}}\n"
    "actuators: {a: {joint: j, force: push}}\n"
    "signals: {twice: 2*push}\n";

FmuOptions options_of(int version) {
  FmuOptions options;
  options.version = version;
  options.name = "sliding";
  options.with_library = true;
  return options;
}

TEST(LibraryFmu, IsC99WithoutWarnings) {
  for (const int version : {2, 3}) {
    const FmuCode fmu = generate_fmu(model_of(sliding), {}, options_of(version));
    const std::string folder = fmu_sources(fmu, "library");
    EXPECT_EQ(
        printed_by(fmt::format("cc -std=c99 -fsyntax-only -Wall -Wextra -Wpedantic -Werror {0}/sliding.c "
                               "{0}/fmi{1}.c",
                               folder, version)),
        "");
  }
}

TEST(LibraryFmu, HasTheVariablesOfCode) {
  FmuOptions options = options_of(3);
  const FmuCode library = generate_fmu(model_of(sliding), {}, options);
  options.with_library = false;
  const FmuCode code = generate_fmu(model_of(sliding), {}, options);
  ASSERT_EQ(library.variables.size(), code.variables.size());
  for (std::size_t k = 0; k < code.variables.size(); ++k) {
    const FmuVariable &a = library.variables[k], &b = code.variables[k];
    EXPECT_EQ(a.name, b.name);
    EXPECT_EQ(a.unit, b.unit);
    EXPECT_EQ(a.role, b.role);
    EXPECT_EQ(a.start, b.start);
    EXPECT_EQ(a.min, b.min);
    EXPECT_EQ(a.max, b.max);
  }
}

TEST(LibraryFmu, StartsWithTheInputsThatAreGiven) {
  RunOptions options;
  options.inputs["push"] = 5;
  const FmuCode fmu = generate_fmu(model_of(sliding), options, options_of(3));
  EXPECT_EQ(fmu.variables.at(1).start, 5);
  options.inputs["pull"] = 5;
  EXPECT_THAT([&] { generate_fmu(model_of(sliding), options, options_of(3)); },
              testing::ThrowsMessage<InputError>(HasSubstr("'pull'")));
}

TEST(LibraryFmu, RefusesOptionsThatDoNotGoTogether) {
  FmuOptions exchange = options_of(3);
  exchange.kind = FmuOptions::Kind::model_exchange;
  EXPECT_THAT([&] { generate_fmu(model_of(sliding), {}, exchange); },
              testing::ThrowsMessage<InputError>(HasSubstr("co-simulation alone")));
  RunOptions options;
  options.integrator = spec::Simulation::Integrator::newmark;
  options.rho = 0.5;
  EXPECT_THAT([&] { generate_fmu(model_of(sliding), options, options_of(3)); },
              testing::ThrowsMessage<InputError>(HasSubstr("rho")));
}

}  // namespace
}  // namespace mimbre::test::library_fmu_test
