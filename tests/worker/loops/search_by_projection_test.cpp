#include "worker/loops/search_by_projection.hpp"

#include <gtest/gtest.h>

#include "tests/synthetic/pose_near.hpp"
#include "tests/synthetic/sea_floor.hpp"

namespace divemesh::loops {
namespace {

using synthetic::SeaFloor;

// Two images of the same floor from places a hand's breadth apart, and a guess that is `off_m` to
// the side.
struct TwoImages {
    explicit TwoImages(double off_m) {
        const SeaFloor floor;
        T_world_to.translation() << 0.1, 0.05, 0.03;
        T_world_to.rotate(Eigen::AngleAxisd(0.06, Eigen::Vector3d::UnitZ()));
        cv::extractChannel(floor.look(T_world_from).left_color, from, 0);
        cv::extractChannel(floor.look(T_world_to).left_color, to, 0);
        for (int i = 0; i < 120; ++i) {
            const Eigen::Vector2d pixel(20.0 + 23.0 * (i % 12), 20.0 + 20.0 * (i / 12));
            points.push_back({pixel, SeaFloor::seen_at(T_world_from, pixel.x(), pixel.y())});
        }
        T_to_from = true_motion();
        T_to_from.translation().x() += off_m;
    }
    Eigen::Isometry3d true_motion() const { return T_world_to.inverse() * T_world_from; }

    Eigen::Isometry3d T_world_from = Eigen::Isometry3d::Identity();
    Eigen::Isometry3d T_world_to = Eigen::Isometry3d::Identity();
    cv::Mat from;
    cv::Mat to;
    std::vector<KnownPoint> points;
    Eigen::Isometry3d T_to_from;  // the guess
};

TEST(SearchByProjectionTest, FindsPointsFromAGuessThatIsTwoPixelsOff) {
    TwoImages images(0.016);
    const auto found = search_by_projection(
        synthetic::small_rig(), images.from, images.points, images.to, images.T_to_from);
    ASSERT_TRUE(found);
    EXPECT_GT(found->size(), 60U);
    EXPECT_THAT(images.T_to_from, synthetic::IsPoseWithin(images.true_motion(), 0.1, 0.004));
}

TEST(SearchByProjectionTest, ThirtyPixelsOffTakeAnApproachInSmallerImages) {
    TwoImages images(0.24);
    const types::RectifiedRig rig = synthetic::small_rig();
    Eigen::Isometry3d without = images.T_to_from;
    EXPECT_FALSE(search_by_projection(rig, images.from, images.points, images.to, without));
    refine_coarse_to_fine(rig, images.from, images.points, images.to, 3, images.T_to_from);
    EXPECT_THAT(images.T_to_from, synthetic::IsPoseWithin(images.true_motion(), 1.0, 0.02));
    EXPECT_TRUE(search_by_projection(rig, images.from, images.points, images.to, images.T_to_from));
}

TEST(SearchByProjectionTest, NothingIsFoundAtAnotherPlace) {
    TwoImages images(0.0);
    const SeaFloor floor;
    Eigen::Isometry3d T_elsewhere = images.T_world_to;
    T_elsewhere.translation().x() += 9.0;
    cv::extractChannel(floor.look(T_elsewhere).left_color, images.to, 0);
    refine_coarse_to_fine(
        synthetic::small_rig(), images.from, images.points, images.to, 3, images.T_to_from);
    EXPECT_FALSE(search_by_projection(
        synthetic::small_rig(), images.from, images.points, images.to, images.T_to_from));
}

}  // namespace
}  // namespace divemesh::loops
