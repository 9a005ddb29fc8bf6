#include "worker/camera/water_index.hpp"

#include <gtest/gtest.h>

namespace divemesh::camera {
namespace {

// Austin and Halikas, "The index of refraction of seawater" (1976), at 1 atmosphere, relative to
// air; between their 525 and 550 nm where 532 nm is not tabulated.
TEST(WaterIndexTest, AgreesWithMeasuredWater) {
    EXPECT_NEAR(water_index(20.0, 0.0), 1.3351, 2e-4);
    EXPECT_NEAR(water_index(20.0, 35.0), 1.3415, 3e-4);
    EXPECT_NEAR(water_index(0.0, 35.0), 1.3431, 4e-4);
}

TEST(WaterIndexTest, SaltAndColdMakeWaterDenser) {
    EXPECT_NEAR(water_index(10.0, 35.0) - water_index(10.0, 0.0), 0.0067, 3e-4);
    EXPECT_GT(water_index(5.0, 20.0), water_index(25.0, 20.0) + 0.001);
}

}  // namespace
}  // namespace divemesh::camera
