#include "worker/estimation/loops/described_view.hpp"

#include <gtest/gtest.h>

#include "tests/synthetic/sea_floor.hpp"
#include "tests/temporary_folder.hpp"
#include "worker/estimation/loops/match_views.hpp"
#include "worker/estimation/loops/place_index.hpp"

namespace divemesh::worker {
namespace {

using synthetic::SeaFloor;

Eigen::Isometry3d camera(double x_m, double y_m, double height_m, double turn_rad) {
    Eigen::Isometry3d T_world_cam = Eigen::Isometry3d::Identity();
    T_world_cam.translation() << x_m, y_m, SeaFloor::kDepth_m - height_m;
    T_world_cam.rotate(Eigen::AngleAxisd(turn_rad, Eigen::Vector3d::UnitZ()));
    return T_world_cam;
}

DescribedView view_of(const Eigen::Isometry3d& T_world_cam) {
    return SeaFloor::view(T_world_cam, SeaFloor().look(T_world_cam));
}

// Share of the matches that are right to 3 px, and their number.
std::pair<double, std::size_t> right_matches(const Eigen::Isometry3d& T_world_a,
                                             const Eigen::Isometry3d& T_world_b) {
    const RectifiedRig rig = synthetic::small_rig();
    const PointPairs pairs = match_views(rig, view_of(T_world_a), view_of(T_world_b));
    std::size_t num_right = 0;
    for (const PointPair& pair : pairs) {
        const Eigen::Vector3d p_b = T_world_b.inverse() * T_world_a * pair.p_previous;
        if ((rig.pixel(p_b) - pair.current_px.head<2>()).norm() < 3.0) ++num_right;
    }
    return {static_cast<double>(num_right) /
                static_cast<double>(std::max<std::size_t>(1, pairs.size())),
            num_right};
}

TEST(DescribedViewTest, MatchesAfterATurnByAQuarterAndAThird) {
    for (const double turn_rad : {0.0, 1.5708, 2.1}) {
        const auto [share, num] =
            right_matches(camera(0.0, 0.0, 2.0, 0.0), camera(0.1, 0.05, 2.0, turn_rad));
        EXPECT_GT(share, 0.7) << turn_rad;
        EXPECT_GE(num, 25U) << turn_rad;
    }
}

TEST(DescribedViewTest, MatchesFromHalfAsFarAgain) {
    const auto [share, num] = right_matches(camera(0.0, 0.0, 1.6, 0.0), camera(0.0, 0.0, 2.4, 0.2));
    EXPECT_GT(share, 0.6);
    EXPECT_GE(num, 12U);
}

TEST(DescribedViewTest, HasAtMostFiveHundredPoints) {
    const DescribedView view = view_of(camera(0.0, 0.0, 2.0, 0.0));
    EXPECT_GE(view.size(), 80U);
    EXPECT_LE(view.size(), 500U);
}

TEST(DescribedViewTest, AFlatPictureHasNoPoints) {
    const cv::Mat flat(240, 320, CV_8U, cv::Scalar(90));
    EXPECT_TRUE(describe_view(flat).empty());
}

TEST(PlaceIndexTest, AViewIsMostLikeTheOneFromNearby) {
    const TemporaryFolder folder;
    const KeyframeStore store(folder.path());
    std::vector<Keyframe> keyframes;
    const auto keep = [&](const DescribedView& view) {
        keyframes.push_back({static_cast<int>(keyframes.size())});
        store.write_view(keyframes.back().frame_index, view);
    };
    for (int i = 0; i < 12; ++i) keep(view_of(camera(3.0 * i, 0.0, 2.0, 0.0)));
    keep(view_of(camera(3.0 * 7 + 0.2, 0.1, 2.0, 0.3)));
    keep({});
    const PlaceIndex index(StoredViews(store, keyframes));
    const auto likeness = index.likeness(12);
    const auto best = std::max_element(likeness.begin(), likeness.begin() + 12);
    EXPECT_EQ(best - likeness.begin(), 7);
    EXPECT_NEAR(likeness[12], 1.0, 1e-4);
    EXPECT_EQ(likeness[13], 0.0F);
}

}  // namespace
}  // namespace divemesh::worker
