#include "worker/features/match_misaligned_stereo.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "tests/synthetic/texture.hpp"

namespace divemesh::features {
namespace {

types::RectifiedFrame frame_with(const Eigen::Vector2d& shift_px) {
    types::RectifiedFrame frame;
    frame.index = 7;
    frame.left = synthetic::textured_image(0.0, 0.0);
    frame.right = synthetic::textured_image(shift_px.x(), shift_px.y(), 0.7, 100.0);
    return frame;
}

TEST(MatchMisalignedStereoTest, FindsPointsOnOtherRowsAndBehindInfinity) {
    for (const Eigen::Vector2d& shift_px : {Eigen::Vector2d(-20.3, 0.0),
                                            Eigen::Vector2d(-20.3, 7.4),
                                            Eigen::Vector2d(-60.6, -7.7),
                                            Eigen::Vector2d(9.2, 3.3)}) {
        const types::StereoMatches matches = match_misaligned_stereo(frame_with(shift_px));

        EXPECT_GT(matches.size(), 20U) << shift_px.transpose();
        const auto num_right = std::ranges::count_if(matches, [&](const types::StereoMatch& match) {
            return match.frame_index == 7 &&
                   (match.right_px - match.left_px - shift_px).norm() < 0.2;
        });
        EXPECT_GT(static_cast<double>(num_right), 0.95 * static_cast<double>(matches.size()))
            << shift_px.transpose();
    }
}

TEST(MatchMisalignedStereoTest, FindsNothingInImagesOfDifferentPlaces) {
    types::RectifiedFrame frame = frame_with({0.0, 0.0});
    frame.right = synthetic::textured_image(1000.0, 400.0);

    EXPECT_LT(match_misaligned_stereo(frame).size(), 5U);
}

}  // namespace
}  // namespace divemesh::features
