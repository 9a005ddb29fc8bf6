#include "worker/loops/separate_segments.hpp"

#include <gtest/gtest.h>

namespace divemesh::loops {
namespace {

// Nine keyframes, 1 s and 0.2 m apart; 2 s before the fourth and before the seventh. All but these
// two share landmarks with the previous one.
struct Dive {
    Dive() {
        std::int64_t now_ns = 0;
        for (int k = 0; k < 9; ++k) {
            const bool lost = k == 3 || k == 6;
            now_ns += lost ? 2'000'000'000 : 1'000'000'000;
            types::Keyframe keyframe;
            keyframe.frame_index = k;
            keyframe.timestamp_ns = now_ns;
            keyframe.T_world_cam.translation().x() = 0.2 * k;
            keyframes.push_back(keyframe);
            if (k == 0 || lost) continue;
            for (int i = 0; i < 20; ++i)
                landmarks.push_back({Eigen::Vector3d::Zero(), {{k - 1}, {k}}});
        }
    }
    std::vector<std::int32_t> number(const std::vector<Loop>& loops) {
        number_segments(DriftModel(keyframes, landmarks, nullptr), loops, keyframes);
        std::vector<std::int32_t> segments;
        for (const types::Keyframe& keyframe : keyframes) segments.push_back(keyframe.segment);
        return segments;
    }

    std::vector<types::Keyframe> keyframes;
    std::vector<types::Landmark> landmarks;
};

using Numbers = std::vector<std::int32_t>;

TEST(NumberSegmentsTest, EveryLongLossOfTheSceneStartsANewSegment) {
    EXPECT_EQ(Dive().number({}), (Numbers{0, 0, 0, 1, 1, 1, 2, 2, 2}));
}

TEST(NumberSegmentsTest, ALossOfLessThanASecondStartsNoSegment) {
    Dive dive;
    for (std::size_t k = 3; k < 9; ++k) dive.keyframes[k].timestamp_ns -= 1'200'000'000;
    EXPECT_EQ(dive.number({}), (Numbers{0, 0, 0, 0, 0, 0, 1, 1, 1}));
}

TEST(NumberSegmentsTest, ALoopJoinsTheSegmentsThatItConnects) {
    Loop loop;
    loop.from = 1;
    loop.to = 8;
    EXPECT_EQ(Dive().number({loop}), (Numbers{0, 0, 0, 1, 1, 1, 0, 0, 0}));
}

TEST(SeparateSegmentsTest, SegmentsDoNotOverlapAndKeepTheirShape) {
    Dive dive;
    dive.number({});
    separate_segments(2.0, dive.keyframes);
    const auto x = [&](std::size_t k) { return dive.keyframes[k].T_world_cam.translation().x(); };
    EXPECT_EQ(x(0), 0.0);
    EXPECT_GE(x(3) - x(2), 4.0 - 1e-12);
    EXPECT_GE(x(6) - x(5), 4.0 - 1e-12);
    for (const std::size_t k : {1, 2, 4, 5, 7, 8}) EXPECT_NEAR(x(k) - x(k - 1), 0.2, 1e-12);
}

TEST(SeparateSegmentsTest, ASingleSegmentStaysInPlace) {
    Dive dive;
    separate_segments(2.0, dive.keyframes);
    for (std::size_t k = 0; k < 9; ++k)
        EXPECT_EQ(dive.keyframes[k].T_world_cam.translation().x(), 0.2 * static_cast<double>(k));
}

}  // namespace
}  // namespace divemesh::loops
