#include "spec/nearest_place.h"

#include <gtest/gtest.h>

#include <cmath>

namespace mimbre::nearest_place_test {
using namespace test;
namespace {

using Eigen::Vector3d;

/// Of two nodes that are both near enough the nearer one is meant, in either order.
TEST(NearestPlace, IsTheNearestAndNotTheFirst) {
  for (const double size : {1e-3, 1.0, 1e3}) {
    const Vector3d far(size, 0, 0), near(size, 3e-7 * size, 0), nearer(size, -1e-7 * size, 0),
        place(size, 0, 0);
    const double within = place_tolerance({Vector3d(0, 0, 0), far}, size);
    EXPECT_EQ(nearest_place({near, nearer}, place, within), 1) << size;
    EXPECT_EQ(nearest_place({nearer, near}, place, within), 0) << size;
    EXPECT_EQ(nearest_place({Vector3d(0, 0, 0), nearer, near, place}, place, within), 3) << size;
    EXPECT_EQ(nearest_place({Vector3d(0, 0, 0), Vector3d(size, 3e-6 * size, 0)}, place, within), -1) << size;
  }
}

}  // namespace
}  // namespace mimbre::nearest_place_test
