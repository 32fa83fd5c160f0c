#include <cmath>
#include <cstdio>

#include "mimbre/beam_reduction.h"
#include "mimbre/diagnostics.h"
#include "mimbre/function.h"
#include "mimbre/model_file.h"
#include "mimbre/results.h"

/// Touches every library that mimbre is linked with, and passes Eigen objects both ways: they must have the
/// same layout and allocator here, in a project that is compiled with flags of its own.
int main() {
  // Expressions.
  if (mimbre::Function::expression("2*x + 1", "x").value(3) != 7) return 1;

  // Finite elements: the lowest frequency of a steel cantilever, (1.875/L)² sqrt(EI/ρA).
  const mimbre::fe::Section square{1e-4, 1e-8 / 12, 1e-8 / 12, 1.4e-9};
  const mimbre::fe::Material steel{2.1e11, 0.3, 7850};
  mimbre::fe::Mesh mesh;
  mesh.nodes = Eigen::Matrix3Xd::Zero(3, 5);
  mesh.nodes.row(0) = Eigen::RowVectorXd::LinSpaced(5, 0, 1);
  for (int i = 0; i < 4; ++i) {
    mimbre::fe::BeamElement element;
    element.nodes = {i, i + 1};
    element.section = square;
    element.material = steel;
    mesh.elements.push_back(element);
  }
  const Eigen::VectorXd frequencies = mimbre::fe::eigenfrequencies(mesh, {0}, 2);
  const double exact = 1.8751 * 1.8751 * std::sqrt(2.1e11 * 1e-8 / 12 / (7850 * 1e-4));
  std::printf("lowest frequency %.3f rad/s, exact %.3f rad/s\n", frequencies[0], exact);
  if (std::abs(frequencies[0] / exact - 1) > 1e-3) return 2;

  // Model files and results: exceptions cross the border with their type.
  try {
    mimbre::load_model("no-such-model.yaml");
    return 3;
  } catch (const mimbre::InputError& error) {
    std::printf("%s\n", error.what());
  }
  try {
    mimbre::read_results("no-such-results.h5");
    return 4;
  } catch (const mimbre::InputError& error) {
    std::printf("%s\n", error.what());
  }
  return 0;
}
