#include "worker/evaluation/surface_error.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "schemas/error.hpp"
#include "tests/synthetic/ideal_rig.hpp"
#include "worker/evaluation/nearest_camera.hpp"
#include "worker/evaluation/surface_index.hpp"
#include "worker/evaluation/surface_samples.hpp"

namespace divemesh::evaluation {
namespace {

// Returns a flat grid at height z with cells of 10 cm.
types::Mesh plane(float z, int cells_x, int cells_y) {
    types::Mesh mesh;
    const auto row = static_cast<std::uint32_t>(cells_x + 1);
    for (int y = 0; y <= cells_y; ++y)
        for (int x = 0; x <= cells_x; ++x)
            mesh.vertices.emplace_back(
                0.1F * static_cast<float>(x), 0.1F * static_cast<float>(y), z);
    for (std::uint32_t y = 0; y < static_cast<std::uint32_t>(cells_y); ++y)
        for (std::uint32_t x = 0; x < row - 1; ++x) {
            const std::uint32_t corner = y * row + x;
            mesh.triangles.push_back({corner, corner + 1, corner + row});
            mesh.triangles.push_back({corner + 1, corner + row + 1, corner + row});
        }
    return mesh;
}

SurfaceErrorInput few_samples() {
    SurfaceErrorInput input;
    input.num_samples = 20'000;
    return input;
}

TEST(SurfaceError, TwoParallelPlanesAreTheirDistanceApart) {
    const SurfaceError error =
        surface_error(plane(0.012F, 10, 10), plane(0, 10, 10), few_samples());
    EXPECT_NEAR(error.accuracy.median_m, 0.012, 1e-6);
    EXPECT_NEAR(error.accuracy.rms_m, 0.012, 1e-6);
    EXPECT_NEAR(error.completeness.median_m, 0.012, 1e-6);
    ASSERT_EQ(error.scores.size(), 4U);
    EXPECT_EQ(error.scores[1].f1, 0.0);  // 10 mm
    EXPECT_EQ(error.scores[2].f1, 1.0);  // 20 mm
}

TEST(SurfaceError, HalfAReconstructionIsAccurateAndHalfComplete) {
    const SurfaceError error = surface_error(plane(0, 10, 20), plane(0, 20, 20), few_samples());
    EXPECT_NEAR(error.scores[0].precision, 1.0, 1e-9);
    EXPECT_NEAR(error.scores[0].recall, 0.5 + 0.005 / 2.0, 1e-3);
    EXPECT_NEAR(error.scores[0].f1, 2.0 * 0.5025 / 1.5025, 1e-3);
    // Over the missing half, distances increase linearly from 0 to 1 m.
    EXPECT_NEAR(error.completeness.rms_m, std::sqrt(1.0 / 6.0), 2e-3);
}

TEST(SurfaceError, TheTrajectorysAlignmentIsAppliedAndNoOther) {
    SurfaceErrorInput input = few_samples();
    input.T_reference_world.translation().z() = 0.5;
    const SurfaceError error = surface_error(plane(-0.47F, 10, 10), plane(0, 10, 10), input);
    EXPECT_NEAR(error.accuracy.median_m, 0.03, 1e-6);
}

TEST(SurfaceError, SurfaceBeyondTheRangeOfEveryCameraIsLeftOut) {
    SurfaceErrorInput input = few_samples();
    input.camera_positions_world = {{0.0, 0.5, 0.0}};
    // A strip of 1 x 10 m; the reference contains its first 5 m.
    const SurfaceError error = surface_error(plane(0, 100, 10), plane(0, 50, 10), input);
    EXPECT_NEAR(error.share_beyond_range, 0.6, 0.01);
    EXPECT_EQ(error.scores[0].precision, 1.0);
}

TEST(SurfaceError, ErrorsAreAlsoStatedOverTheRange) {
    SurfaceErrorInput input = few_samples();
    // So high above 1 m2 that every range is 100 m to within a thousandth.
    input.camera_positions_world = {{0.5, 0.5, 100.0}};
    input.max_range_m = 200.0;
    const SurfaceError error = surface_error(plane(0.2F, 10, 10), plane(0, 10, 10), input);
    EXPECT_NEAR(error.relative.value().median, 0.002, 1e-5);
    EXPECT_NEAR(error.relative.value().p80, 0.002, 1e-5);
}

TEST(SurfaceError, TheReferenceNearACameraIsSummedUpByItself) {
    SurfaceErrorInput input = few_samples();
    input.camera_positions_world = {{0.5, 0.5, 0.0}};
    // The estimate contains the first 2 m of a strip of 1 x 10 m: all that is within 1.5 m of the
    // camera.
    input.near_range_m = 1.5;
    const SurfaceError error = surface_error(plane(0.01F, 20, 10), plane(0, 100, 10), input);
    EXPECT_NEAR(error.near_completeness.value().p90_m, 0.01, 1e-6);
    EXPECT_GT(error.completeness.median_m, 1.0);
}

// A strip of 1 x 10 m whose first 5 m are true. The camera's range of 4 m ends before.
TEST(SurfaceError, FalseSurfaceCountsWhateverItsRange) {
    SurfaceErrorInput input = few_samples();
    input.camera_positions_world = {{0.0, 0.5, 0.0}};
    const SurfaceError error = surface_error(plane(0, 100, 10), plane(0, 50, 10), input);
    EXPECT_EQ(error.scores[3].precision, 1.0);
    EXPECT_NEAR(error.false_share_50mm, (10.0 - 5.05) / 10.0, 2e-3);
    input.camera_positions_world.clear();
    EXPECT_NEAR(surface_error(plane(0, 100, 10), plane(0, 50, 10), input).false_share_50mm,
                (10.0 - 5.05) / 10.0,
                2e-3);
}

// A strip of 1 x 10 m of which the reference shows the first 5 m. A second sheet lies 20 cm above
// the last metre, where nothing is.
TEST(SurfaceError, OurSurfaceIsComparedWithTheWholeScene) {
    SurfaceErrorInput input = few_samples();
    const types::Mesh scene = plane(0, 100, 10);
    types::Mesh ours = scene;
    const auto first = static_cast<std::uint32_t>(ours.vertices.size());
    for (const Eigen::Vector3f& vertex : plane(0.2F, 10, 10).vertices)
        ours.vertices.emplace_back(vertex + Eigen::Vector3f(9.0F, 0.0F, 0.0F));
    for (const auto& triangle : plane(0, 10, 10).triangles)
        ours.triangles.push_back({first + triangle[0], first + triangle[1], first + triangle[2]});
    input.scene = &scene;
    const SurfaceError error = surface_error(ours, plane(0, 50, 10), input);
    EXPECT_NEAR(error.false_share_50mm, 1.0 / 11.0, 1e-3);
    EXPECT_NEAR(error.scores[0].precision, 10.0 / 11.0, 1e-3);
    EXPECT_EQ(error.scores[0].recall, 1.0);
}

// The pairs are 1 m above a bed of 4 x 2 m and look down at it: both images of one show it for
// 0.62 < x < 1.5 (the right camera is 12 cm to the right). The mesh ends at x = 1.
TEST(SurfaceError, OfTheReferenceThatThreePairsSawTheShareWithin20mmIsTold) {
    SurfaceErrorInput input = few_samples();
    StereoPairs pairs{synthetic::ideal_cameras(synthetic::ideal_rig(500, 1000, 500.0)), {}};
    pairs.T_world_cam0.assign(3, Eigen::Isometry3d(Eigen::Translation3d(1.0, 1.0, -1.0)));
    input.pairs = pairs;
    const types::Mesh bed = plane(0, 40, 20);
    const SurfaceError error = surface_error(plane(0, 10, 20), bed, input);
    EXPECT_NEAR(error.share_20mm.value(), (1.02 - 0.62) / (1.5 - 0.62), 0.01);
    input.pairs->T_world_cam0.pop_back();
    EXPECT_FALSE(surface_error(plane(0, 10, 20), bed, input).share_20mm) << "two pairs";
}

TEST(NearestCamera, AgreesWithASearchOverAll) {
    std::vector<Eigen::Vector3f> path;
    for (int i = 0; i < 500; ++i) {
        const float t = 0.05F * static_cast<float>(i);
        path.emplace_back(std::cos(t) * t, std::sin(t) * t, 0.1F * t);
    }
    const NearestCamera cameras(path);
    for (float x = -20.0F; x <= 20.0F; x += 3.3F)
        for (float y = -20.0F; y <= 20.0F; y += 3.3F) {
            const Eigen::Vector3f point(x, y, 1.0F);
            float nearest = 1e9F;
            for (const auto& camera : path) nearest = std::min(nearest, (camera - point).norm());
            EXPECT_FLOAT_EQ(cameras.distance_m(point), nearest);
        }
}

TEST(SurfaceError, DoesNotDependOnTheNumberOfThreads) {
    SurfaceErrorInput one = few_samples();
    one.num_threads = 1;
    SurfaceErrorInput four = few_samples();
    four.num_threads = 4;
    const types::Mesh mesh = plane(0.01F, 7, 9);
    const types::Mesh reference = plane(0, 10, 8);
    EXPECT_EQ(to_metrics(surface_error(mesh, reference, one)),
              to_metrics(surface_error(mesh, reference, four)));
}

TEST(SurfaceError, AMeshWithoutAreaIsRefused) {
    EXPECT_THROW(surface_error({}, plane(0, 1, 1), few_samples()), Error);
    EXPECT_THROW(surface_error(plane(0, 1, 1), {}, few_samples()), Error);
}

TEST(SurfaceSamples, ShareTheirNumberByArea) {
    types::Mesh mesh;  // triangles of area 3 and 1
    mesh.vertices = {{0, 0, 0}, {3, 0, 0}, {0, 2, 0}, {0, 0, 9}, {1, 0, 9}, {0, 2, 9}};
    mesh.triangles = {{0, 1, 2}, {3, 4, 5}};
    int num_low = 0;
    Eigen::Vector3f sum = Eigen::Vector3f::Zero();
    for (const Eigen::Vector3f& sample : sample_surface(mesh, 40'000, 7)) {
        if (sample.z() > 1.0F) continue;
        ++num_low;
        sum += sample;
    }
    EXPECT_NEAR(num_low, 30'000, 1);
    const Eigen::Vector3f centre = sum / static_cast<float>(num_low);
    EXPECT_NEAR(centre.x(), 1.0F, 0.02F);
    EXPECT_NEAR(centre.y(), 2.0F / 3.0F, 0.015F);
}

// Returns the distance to the nearest of many points of the triangle.
float sampled_distance(const Eigen::Vector3f& point, const types::Mesh& triangle) {
    float nearest = 1e9F;
    for (int i = 0; i <= 200; ++i)
        for (int j = 0; i + j <= 200; ++j) {
            const float u = static_cast<float>(i) / 200.0F;
            const float v = static_cast<float>(j) / 200.0F;
            const Eigen::Vector3f& a = triangle.vertices[0];
            nearest = std::min(
                nearest,
                (a + u * (triangle.vertices[1] - a) + v * (triangle.vertices[2] - a) - point)
                    .norm());
        }
    return nearest;
}

TEST(SurfaceIndex, NearestPointAgreesWithASearchOverTheTriangle) {
    types::Mesh mesh;
    mesh.vertices = {{0, 0, 0}, {1, 0.2F, 0}, {0.3F, 0.8F, 0.5F}};
    mesh.triangles = {{0, 1, 2}};
    const SurfaceIndex index(mesh);
    for (int i = 0; i < 7; ++i)
        for (int j = 0; j < 7; ++j) {
            const Eigen::Vector3f point(
                0.4F * static_cast<float>(i) - 1.0F, 0.4F * static_cast<float>(j) - 1.0F, 0.6F);
            EXPECT_NEAR(index.distance_m(point), sampled_distance(point, mesh), 4e-3F);
        }
}

TEST(SurfaceIndex, ARayStopsAtTheFirstSurface) {
    const types::Mesh mesh = plane(1.5F, 10, 10);
    const SurfaceIndex index(mesh);
    EXPECT_EQ(index.distance_m({0.5F, 0.5F, 0}, 1.0F), 1.0F) << "no farther than asked for";
    EXPECT_NEAR(index.first_hit_m({0.5F, 0.5F, 0}, Eigen::Vector3f::UnitZ()).value(), 1.5F, 1e-6F);
    EXPECT_FALSE(index.first_hit_m({0.5F, 0.5F, 0}, Eigen::Vector3f::UnitX()).has_value());
}

}  // namespace
}  // namespace divemesh::evaluation
