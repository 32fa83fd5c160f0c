#include "fe/solve/block_lanczos.h"

#include <gmock/gmock.h>

#include <limits>
#include <stdexcept>

namespace mimbre::fe::block_lanczos_test {
namespace {

using testing::HasSubstr;

/// K and M diagonal: λ = k/m.
Pencil diagonal(const Eigen::VectorXd& stiffness, const Eigen::VectorXd& mass) {
  Pencil pencil;
  pencil.size = stiffness.size();
  pencil.solve = [stiffness](const Eigen::MatrixXd& b) -> Eigen::MatrixXd {
    return stiffness.cwiseInverse().asDiagonal() * b;
  };
  pencil.mass = [mass](const Eigen::MatrixXd& x) -> Eigen::MatrixXd { return mass.asDiagonal() * x; };
  return pencil;
}

std::string refusal(const Eigen::VectorXd& stiffness, const Eigen::VectorXd& mass, int count) {
  try {
    block_lanczos(diagonal(stiffness, mass), count);
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return "none";
}

TEST(BlockLanczos, FindsTheFiniteSolutionsOfASemidefiniteMass) {
  const Eigen::VectorXd stiffness = Eigen::VectorXd::LinSpaced(20, 1, 20);
  Eigen::VectorXd mass = Eigen::VectorXd::Zero(20);
  mass[3] = 2;
  mass[7] = 1;
  mass[19] = 10;
  const Modes modes = block_lanczos(diagonal(stiffness, mass), 3);
  EXPECT_NEAR(modes.eigenvalues[0], 2, 1e-12);
  EXPECT_NEAR(modes.eigenvalues[1], 2, 1e-12);
  EXPECT_NEAR(modes.eigenvalues[2], 8, 1e-12);
  EXPECT_THAT(refusal(stiffness, mass, 4), HasSubstr("fewer modes of finite frequency than asked for"));
  EXPECT_EQ(block_lanczos_below(diagonal(stiffness, mass), 5).eigenvalues.size(), 2);
}

TEST(BlockLanczos, RefusesWhatHasNoModes) {
  const Eigen::VectorXd ones = Eigen::VectorXd::Ones(20);
  EXPECT_THAT(refusal(ones, 0 * ones, 1), HasSubstr("mass that counts"));
  EXPECT_THAT(refusal(ones, 1e-200 * ones, 1), HasSubstr("mass that counts"));
  EXPECT_THAT(refusal(ones, -ones, 1), HasSubstr("negative kinetic energy"));
  EXPECT_THAT(refusal(1e-200 * ones, ones, 1), HasSubstr("double precision"));
  EXPECT_THAT(refusal(ones, std::numeric_limits<double>::quiet_NaN() * ones, 1),
              HasSubstr("double precision"));
}

}  // namespace
}  // namespace mimbre::fe::block_lanczos_test
