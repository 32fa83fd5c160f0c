#include "base/helper_threads.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <vector>

#include "mimbre/model_file.h"
#include "mimbre/simulation.h"
#include "reduction/large_factor.h"
#include "support/clocked.h"

namespace mimbre {
namespace {

int threads() {
  const std::filesystem::directory_iterator tasks("/proc/self/task");
  return static_cast<int>(std::distance(begin(tasks), end(tasks)));
}

/// One that has ended is listed for a moment longer.
bool is_alone() {
  return test::comes_true([] { return threads() == 1; });
}

/// Dense enough for a supernode that a BLAS with threads shares among them.
void factorise() {
  constexpr int n = 1200;
  std::vector<Eigen::Triplet<double>> entries;
  for (int i = 0; i < n; ++i)
    for (int j = std::max(0, i - 400); j < std::min(n, i + 401); ++j)
      entries.emplace_back(i, j, i == j ? 801.0 : 1.0 / (1 + std::abs(i - j)));
  Eigen::SparseMatrix<double> matrix(n, n);
  matrix.setFromTriplets(entries.begin(), entries.end());
  const fe::LargeFactor solver(matrix, "not positive definite");
  const Eigen::VectorXd ones = Eigen::VectorXd::Ones(n);
  EXPECT_LT((matrix * solver.solve(ones) - ones).norm(), 1e-9);
}

// OpenBLAS starts its threads when it is loaded, and again with every factorisation. They wait by spinning.
TEST(HelperThreads, NoneIsLeftWhenSteppingStarts) {
  if (!std::filesystem::exists("/proc/self/task")) GTEST_SKIP() << "needs /proc";
  const auto model = Model::compile(load_model(MIMBRE_SOURCE_DIR "/examples/pendulum/flexible.yaml"));
  Simulation simulation(model);
  EXPECT_TRUE(is_alone());
}

TEST(HelperThreads, NoneIsLeftAfterAFactorisationAndTheNextOneWorks) {
  if (!std::filesystem::exists("/proc/self/task")) GTEST_SKIP() << "needs /proc";
  for (int k = 0; k < 3; ++k) {
    factorise();
    EXPECT_TRUE(is_alone());
  }
}

TEST(HelperThreads, OthersThatNeedThemKeepThem) {
  if (!std::filesystem::exists("/proc/self/task")) GTEST_SKIP() << "needs /proc";
  {
    const HelperThreads held;
    factorise();
    const int before = threads();
    end_helper_threads();
    EXPECT_EQ(threads(), before);
  }
  EXPECT_TRUE(is_alone());
}

}  // namespace
}  // namespace mimbre
