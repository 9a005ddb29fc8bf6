#include "worker/simulator/scene.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <map>

#include "worker/simulator/ray_caster.hpp"

namespace divemesh::simulator {
namespace {

constexpr double kPath_m = 12.0;

// Returns true if a ray towards the point, from one of 26 directions, ends there.
bool lies_on_surface(const RayCaster& caster, const Eigen::Vector3f& p) {
    constexpr float kAway_m = 0.02F;
    for (int i = 0; i < 27; ++i) {
        const Eigen::Vector3f side(static_cast<float>(i % 3 - 1),
                                   static_cast<float>(i / 3 % 3 - 1),
                                   static_cast<float>(i / 9 - 1));
        if (side.isZero()) continue;
        // The target is slightly inside, because the ends are on edges and corners.
        const Eigen::Vector3f from = kAway_m * side.normalized();
        const RayHit hit = caster.cast(p + from, -from.normalized());
        if (hit.valid() && std::abs(hit.t - kAway_m) < 5e-4F) return true;
    }
    return false;
}

std::map<std::string, Eigen::AlignedBox3f> objects_of(const Scene& scene) {
    std::map<std::string, Eigen::AlignedBox3f> boxes;
    for (std::size_t i = 0; i < scene.triangles.size(); ++i)
        for (const std::uint32_t vertex : scene.triangles[i])
            boxes[scene.objects[scene.triangle_object[i]].name].extend(scene.vertices[vertex]);
    return boxes;
}

class EverySceneTest : public ::testing::TestWithParam<SceneKind> {};

TEST_P(EverySceneTest, MeasuredLengthsEndOnTheSurface) {
    const Scene scene = make_scene(GetParam(), 11, 1, kPath_m);
    const RayCaster caster(scene.vertices, scene.triangles);
    ASSERT_GE(scene.distances.size(), 5U);
    for (const SceneDistance& entry : scene.distances) {
        EXPECT_NEAR((entry.distance.a_world - entry.distance.b_world).norm(),
                    entry.distance.distance_m,
                    1e-6);
        EXPECT_TRUE(lies_on_surface(caster, entry.distance.a_world.cast<float>()))
            << entry.distance.name << " a";
        EXPECT_TRUE(lies_on_surface(caster, entry.distance.b_world.cast<float>()))
            << entry.distance.name << " b";
    }
}

TEST_P(EverySceneTest, NothingStandsInTheWayOfTheDiver) {
    const Scene scene = make_scene(GetParam(), 12, 1, kPath_m);
    const RayCaster caster(scene.vertices, scene.triangles);
    const auto motion = DiverMotion::open_path(scene.path, kPath_m, 12);
    for (double t_s = 0.0; t_s < motion.duration_s(); t_s += 0.5) {
        const MotionState state = motion.at(t_s);
        const Eigen::Vector3f from = state.T_world_imu.translation().cast<float>();
        for (const Eigen::Vector3d& side : {Eigen::Vector3d(1, 0, 0),
                                            Eigen::Vector3d(1, 1, 0),
                                            Eigen::Vector3d(1, -1, 0),
                                            Eigen::Vector3d(0, 0, -1)}) {
            const Eigen::Vector3d direction = state.T_world_imu.linear() * side.normalized();
            EXPECT_FALSE(caster.is_blocked(from, direction.cast<float>(), 0.35F)) << t_s << " s";
        }
    }
}

TEST_P(EverySceneTest, AYearChangesTheListedObjectsAndNothingElse) {
    const auto before = objects_of(make_scene(GetParam(), 11, 1, kPath_m));
    const Scene later = make_scene(GetParam(), 11, 2, kPath_m);
    auto after = objects_of(later);
    ASSERT_FALSE(later.changes.empty());
    for (const SceneChange& change : later.changes) {
        EXPECT_EQ(before.contains(change.name), change.kind != "new") << change.name;
        EXPECT_EQ(after.contains(change.name), change.kind != "loss") << change.name;
        if (change.kind == "growth") {
            EXPECT_NEAR(
                change.volume_after_m3 / change.volume_before_m3, std::pow(7.0 / 6.0, 3), 0.01);
        }
        after.erase(change.name);
    }
    for (const auto& [name, box] : after) {
        ASSERT_TRUE(before.contains(name)) << name;
        EXPECT_TRUE(box.isApprox(before.at(name))) << name;
    }
}

INSTANTIATE_TEST_SUITE_P(
    Scenes,
    EverySceneTest,
    ::testing::Values(SceneKind::Tank, SceneKind::Barge, SceneKind::Reef, SceneKind::Transect),
    [](const auto& instance) { return std::string(to_string(instance.param)); });

// Directions from the camera to the corners and edges of the ground in the image, beside and below
// its centre; x forward, y left, z up.
const std::array<Eigen::Vector3d, 5> kViews = {Eigen::Vector3d(1, 0, 0),
                                               Eigen::Vector3d(1, 0.7, 0),
                                               Eigen::Vector3d(1, -0.7, 0),
                                               Eigen::Vector3d(1, 0.7, -0.5),
                                               Eigen::Vector3d(1, -0.7, -0.5)};

TEST(TransectScene, GroundIsInSightFromBeginningToEndOfALongStraightPath) {
    constexpr double kLong_m = 40.0;
    const Scene scene = make_scene(SceneKind::Transect, 13, 1, kLong_m);
    const RayCaster caster(scene.vertices, scene.triangles);
    const auto motion = DiverMotion::open_path(scene.path, kLong_m, 13);
    for (double t_s = 0.0; t_s <= motion.duration_s(); t_s += 0.5) {
        const MotionState state = motion.at(t_s);
        const Eigen::Vector3f from = state.T_world_imu.translation().cast<float>();
        for (const Eigen::Vector3d& view : kViews) {
            const Eigen::Vector3d direction = state.T_world_imu.linear() * view.normalized();
            const RayHit hit = caster.cast(from, direction.cast<float>());
            EXPECT_TRUE(hit.valid() && hit.t > 0.3F && hit.t < 5.0F) << t_s << " s " << hit.t;
        }
    }
}

TEST(TransectScene, ALongerPathSeesTheSamePlaceAndMore) {
    const auto less = objects_of(make_scene(SceneKind::Transect, 13, 1, 10.0));
    const auto more = objects_of(make_scene(SceneKind::Transect, 13, 1, 14.0));
    EXPECT_GT(more.size(), less.size());
    for (const auto& [name, box] : less) {
        ASSERT_TRUE(more.contains(name)) << name;
        if (name == "rock" || name == "sand")
            EXPECT_NEAR(more.at(name).sizes().x() - box.sizes().x(), 4.0F, 0.1F) << name;
        else
            EXPECT_TRUE(box.isApprox(more.at(name))) << name;
    }
}

}  // namespace
}  // namespace divemesh::simulator
