#include "worker/calibration/calibration_priors.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/worker/calibration/rough_floor_pairs.hpp"

namespace divemesh::calibration {
namespace {

TEST(CalibrationPriorsTest, PrincipalPointsAreAsUncertainAsAnImageWasShifted) {
    constexpr int kRight = types::LensChange::kSize;
    constexpr int kDown = types::LensChange::kCentreDown;
    types::RigAlignment alignment;
    const LensChanges usual = lens_prior_sigmas(stated_rig(), alignment);
    alignment.change.values[types::RigChange::kCentreDown] = -8.0;
    EXPECT_EQ(lens_prior_sigmas(stated_rig(), alignment), usual);  // found, but not applied

    alignment.applied = true;
    LensChanges shifted = lens_prior_sigmas(stated_rig(), alignment);

    EXPECT_NEAR(usual[kDown], 1.0, 1e-12);  // px, of a careful calibration at 640 px
    EXPECT_NEAR(shifted[kDown], std::hypot(1.0, 8.0), 1e-12);
    EXPECT_NEAR(shifted[kRight + kDown], std::hypot(1.0, 8.0), 1e-12);
    shifted[kDown] = usual[kDown];
    shifted[kRight + kDown] = usual[kRight + kDown];
    EXPECT_EQ(shifted, usual);
}

}  // namespace
}  // namespace divemesh::calibration
