#include "worker/pipeline/simplification_error.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace divemesh::pipeline {
namespace {

// Returns a pyramid of 0.3 m height over a square of 2 m, or the square alone.
types::Mesh square(bool with_apex) {
    types::Mesh mesh;
    mesh.vertices = {{-1, -1, 0}, {1, -1, 0}, {1, 1, 0}, {-1, 1, 0}};
    if (!with_apex) {
        mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
        return mesh;
    }
    mesh.vertices.emplace_back(0, 0, 0.3F);
    mesh.triangles = {{0, 1, 4}, {1, 2, 4}, {2, 3, 4}, {3, 0, 4}};
    return mesh;
}

TEST(SimplificationErrorTest, IsTheHeightOfWhatWasCutOff) {
    const auto error = simplification_error(square(true), square(false), 2, base::ignore_progress);
    EXPECT_EQ(error.num_triangles_before, 4);
    EXPECT_NEAR(error.max_m, 0.3, 1e-6);
    EXPECT_NEAR(error.rms_m, 0.3 / std::sqrt(5.0), 1e-6);
}

TEST(SimplificationErrorTest, IsNothingWhereNothingChanged) {
    EXPECT_NEAR(simplification_error(square(true), square(true), 1, base::ignore_progress).max_m,
                0.0,
                1e-7);
}

}  // namespace
}  // namespace divemesh::pipeline
