#pragma once

#include <gtest/gtest.h>

#include <memory>

#include "tests/temporary_folder.hpp"
#include "worker/dive/dive.hpp"
#include "worker/simulator/simulate.hpp"

namespace divemesh {

// Tests on a short dive in the tank, which is rendered once for the suite.
class ShortTankDive : public testing::Test {
protected:
    static void render(double length_m) {
        folder_ = std::make_unique<TemporaryFolder>();
        simulator::simulate({.scene = simulator::SceneKind::Tank,
                             .out = *folder_ / "dive",
                             .length_m = length_m,
                             .rate_hz = 8.0,
                             .width_px = 320,
                             .height_px = 240});
        dive_ = dive::Dive::open(*folder_ / "dive", *folder_ / "scratch");
    }
    static void TearDownTestSuite() {
        dive_.reset();
        folder_.reset();
    }

    inline static std::unique_ptr<TemporaryFolder> folder_;
    inline static std::unique_ptr<dive::Dive> dive_;
};

}  // namespace divemesh
