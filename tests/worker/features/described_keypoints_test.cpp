#include "worker/features/described_keypoints.hpp"

#include <gtest/gtest.h>

#include <array>
#include <opencv2/imgproc.hpp>

#include "tests/synthetic/sea_floor.hpp"
#include "tests/temporary_folder.hpp"
#include "worker/loops/inverted_index.hpp"
#include "worker/loops/match_keypoints.hpp"

namespace divemesh::features {
namespace {

using synthetic::SeaFloor;

Eigen::Isometry3d camera(double x_m, double y_m, double height_m, double rotation_rad) {
    Eigen::Isometry3d T_world_cam = Eigen::Isometry3d::Identity();
    T_world_cam.translation() << x_m, y_m, SeaFloor::kDepth_m - height_m;
    T_world_cam.rotate(Eigen::AngleAxisd(rotation_rad, Eigen::Vector3d::UnitZ()));
    return T_world_cam;
}

DescribedKeypoints view_of(const Eigen::Isometry3d& T_world_cam) {
    return SeaFloor::view(T_world_cam, SeaFloor().look(T_world_cam));
}

// Returns the share of matches that are correct to 3 px, and the number of matches.
std::pair<double, std::size_t> right_matches(const Eigen::Isometry3d& T_world_a,
                                             const Eigen::Isometry3d& T_world_b) {
    const types::RectifiedRig rig = synthetic::small_rig();
    const odometry::PointPairs pairs =
        loops::match_keypoints(rig, view_of(T_world_a), view_of(T_world_b));
    std::size_t num_right = 0;
    for (const odometry::PointPair& pair : pairs) {
        const Eigen::Vector3d p_b = T_world_b.inverse() * T_world_a * pair.p_previous;
        if ((rig.pixel(p_b) - pair.current_px.head<2>()).norm() < 3.0) ++num_right;
    }
    return {static_cast<double>(num_right) /
                static_cast<double>(std::max<std::size_t>(1, pairs.size())),
            num_right};
}

TEST(DescribedKeypointsTest, MatchesAfterATurnByAQuarterAndAThird) {
    for (const double rotation_rad : {0.0, 1.5708, 2.1}) {
        const auto [share, num] =
            right_matches(camera(0.0, 0.0, 2.0, 0.0), camera(0.1, 0.05, 2.0, rotation_rad));
        EXPECT_GT(share, 0.7) << rotation_rad;
        EXPECT_GE(num, 25U) << rotation_rad;
    }
}

TEST(DescribedKeypointsTest, MatchesFromHalfAsFarAgain) {
    const auto [share, num] = right_matches(camera(0.0, 0.0, 1.6, 0.0), camera(0.0, 0.0, 2.4, 0.2));
    EXPECT_GT(share, 0.6);
    EXPECT_GE(num, 12U);
}

TEST(DescribedKeypointsTest, HasAtMostFiveHundredPoints) {
    const DescribedKeypoints view = view_of(camera(0.0, 0.0, 2.0, 0.0));
    EXPECT_GE(view.size(), 80U);
    EXPECT_LE(view.size(), 500U);
}

cv::Mat blurred_noise(cv::Size size) {
    cv::Mat image(size, CV_8U);
    cv::RNG(7).fill(image, cv::RNG::UNIFORM, 0, 255);
    cv::GaussianBlur(image, image, {}, 4.0);
    cv::normalize(image, image, 0, 255, cv::NORM_MINMAX);
    return image;
}

TEST(DescribedKeypointsTest, AreInAllQuartersOfALargeImage) {
    const cv::Size size(1920, 1080);
    const DescribedKeypoints view = describe_keypoints(blurred_noise(size));
    EXPECT_LE(view.size(), 500U);
    std::array<int, 4> num_in_quarter{};
    for (const DescribedKeypoint& point : view) {
        EXPECT_TRUE(cv::Rect2f({}, cv::Size2f(size)).contains({point.u_px, point.v_px}));
        ++num_in_quarter[(point.u_px > 960.0F ? 1U : 0U) + (point.v_px > 540.0F ? 2U : 0U)];
    }
    for (const int num : num_in_quarter) EXPECT_GE(num, 60);
}

TEST(DescribedKeypointsTest, OfALargeImageAreThoseOfAReducedOneAtFullPositions) {
    const cv::Mat large = blurred_noise({1440, 1080});
    cv::Mat half;
    cv::resize(large, half, {720, 540}, 0.0, 0.0, cv::INTER_AREA);
    const DescribedKeypoints expected = describe_keypoints(half);
    const DescribedKeypoints found = describe_keypoints(large);
    ASSERT_EQ(found.size(), expected.size());
    for (std::size_t i = 0; i < found.size(); ++i) {
        EXPECT_NEAR(found[i].u_px, 2.0F * expected[i].u_px + 0.5F, 1e-3F);
        EXPECT_NEAR(found[i].v_px, 2.0F * expected[i].v_px + 0.5F, 1e-3F);
        EXPECT_NEAR(found[i].scale, 2.0F * expected[i].scale, 1e-5F);
        EXPECT_EQ(found[i].descriptor, expected[i].descriptor);
    }
}

TEST(DescribedKeypointsTest, ImagesOfUsualSizeAreDescribedAsTheyAre) {
    EXPECT_EQ(description_scale({640, 480}), 1.0);
    EXPECT_EQ(description_scale({752, 480}), 1.0);
    EXPECT_EQ(description_scale({832, 624}), 1.0);
    EXPECT_EQ(description_scale({1920, 1080}), 1920.0 / 720.0);
}

TEST(DescribedKeypointsTest, AFlatImageHasNoPoints) {
    const cv::Mat flat(240, 320, CV_8U, cv::Scalar(90));
    EXPECT_TRUE(describe_keypoints(flat).empty());
}

TEST(PlaceIndexTest, AViewIsMostLikeTheOneFromNearby) {
    const TemporaryFolder folder;
    const keyframes::KeyframeStore store(folder.path());
    std::vector<types::Keyframe> keyframes;
    const auto keep = [&](const DescribedKeypoints& view) {
        keyframes.push_back({static_cast<int>(keyframes.size())});
        store.write_keypoints(keyframes.back().frame_index, view);
    };
    for (int i = 0; i < 12; ++i) keep(view_of(camera(3.0 * i, 0.0, 2.0, 0.0)));
    keep(view_of(camera(3.0 * 7 + 0.2, 0.1, 2.0, 0.3)));
    keep({});
    const loops::InvertedIndex index(loops::StoredKeypoints(store, keyframes));
    const auto similarity = index.similarity(12);
    const auto best = std::max_element(similarity.begin(), similarity.begin() + 12);
    EXPECT_EQ(best - similarity.begin(), 7);
    EXPECT_NEAR(similarity[12], 1.0, 1e-4);
    EXPECT_EQ(similarity[13], 0.0F);
}

}  // namespace
}  // namespace divemesh::features
