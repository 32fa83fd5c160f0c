#include "base/one_thread.h"

#include <dlfcn.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <thread>
#include <vector>

#include "mimbre/model_file.h"
#include "mimbre/simulation.h"
#include "mimbre/threads.h"
#include "reduction/factor/large_factor.h"
#include "support/clocked.h"

namespace mimbre::one_thread_test {
namespace {

int threads() {
  const std::filesystem::directory_iterator tasks("/proc/self/task");
  return static_cast<int>(std::distance(begin(tasks), end(tasks)));
}

template <class Function>
Function* found(const char* name) {
  return reinterpret_cast<Function*>(dlsym(RTLD_DEFAULT, name));
}

/// Dense enough for a supernode that a BLAS with threads shares among them.
Eigen::VectorXd factorise() {
  constexpr int n = 1200;
  std::vector<Eigen::Triplet<double>> entries;
  for (int i = 0; i < n; ++i)
    for (int j = std::max(0, i - 400); j < std::min(n, i + 401); ++j)
      entries.emplace_back(i, j, i == j ? 801.0 : 1.0 / (1 + std::abs(i - j)));
  Eigen::SparseMatrix<double> matrix(n, n);
  matrix.setFromTriplets(entries.begin(), entries.end());
  const fe::LargeFactor solver(matrix, "not positive definite");
  const Eigen::VectorXd ones = Eigen::VectorXd::Ones(n), x = solver.solve(ones);
  EXPECT_LT((matrix * x - ones).norm(), 1e-9);
  return x;
}

/// A host's thread pools are as it left them, whatever is constructed and factorised.
TEST(OneThread, LeavesTheHostsThreadsAlone) {
  auto* const openmp = found<int()>("omp_get_max_threads");
  auto* const set_openmp = found<void(int)>("omp_set_num_threads");
  auto* const levels = found<int()>("omp_get_max_active_levels");
  const int levels_before = levels ? levels() : 0;
  auto* const blas = found<int()>("openblas_get_num_threads");
  auto* const set_blas = found<void(int)>("openblas_set_num_threads");
  if (set_blas) set_blas(2);
  if (set_openmp) set_openmp(3);
  const int before = threads();
  const auto model = Model::compile(load_model(MIMBRE_SOURCE_DIR "/examples/pendulum/flexible.yaml"));
  const Simulation simulation(model);
  factorise();
  EXPECT_EQ(blas ? blas() : 2, 2);
  EXPECT_EQ(openmp ? openmp() : 3, 3);
  EXPECT_EQ(levels ? levels() : 0, levels_before);
  EXPECT_GE(threads(), before);
}

TEST(OneThread, IsOfThisThreadAlone) {
  auto* const levels = found<int()>("omp_get_max_active_levels");
  auto* const set_levels = found<void(int)>("omp_set_max_active_levels");
  if (!levels || !set_levels) GTEST_SKIP() << "no OpenMP here";
  set_levels(3);
  const int of_others = [&] {
    int of_another = 0;
    std::thread([&] { of_another = levels(); }).join();
    return of_another;
  }();
  {
    const OneThread alone;
    EXPECT_EQ(levels(), 0);
    {
      const OneThread within;
      EXPECT_EQ(levels(), 0);
    }
    EXPECT_EQ(levels(), 0);
    std::thread([&] { EXPECT_EQ(levels(), of_others); }).join();
  }
  EXPECT_EQ(levels(), 3);
}

/// OpenBLAS starts its threads when it is loaded. They wait by spinning, and share work in another order.
TEST(OneThread, IsTheOnlyOneOnceAProcessAsksForIt) {
  if (!std::filesystem::exists("/proc/self/task")) GTEST_SKIP() << "needs /proc";
  use_one_blas_thread();
  const Eigen::VectorXd x = factorise();
  // One that has ended is listed for a moment longer.
  EXPECT_TRUE(test::comes_true([] { return threads() == 1; }));
  if (auto* const set = found<void(int)>("openblas_set_num_threads")) {
    set(1);
    use_one_blas_thread();
  }
  EXPECT_EQ(factorise(), x);
  EXPECT_TRUE(test::comes_true([] { return threads() == 1; }));
}

/// Sums of kernels for other processors differ in the last bits.
TEST(OneThread, UsesTheKernelsOfTheBaseline) {
  auto* const core = found<char*()>("openblas_get_corename");
  if (!core || !found<void()>("gotoblas_dynamic_init")) GTEST_SKIP() << "no OpenBLAS with kernels to choose";
  if (!__builtin_cpu_supports("avx2") || std::getenv("OPENBLAS_CORETYPE"))
    GTEST_SKIP() << "no AVX2, or chosen";
  use_one_blas_thread();
  EXPECT_STREQ(core(), "Haswell");
  EXPECT_EQ(std::getenv("OPENBLAS_CORETYPE"), nullptr);
}

}  // namespace
}  // namespace mimbre::one_thread_test
