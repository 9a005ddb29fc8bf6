#include "worker/markers/survey_markers.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "tests/synthetic/ideal_rig.hpp"
#include "tests/synthetic/sensor_recording.hpp"
#include "tests/worker/markers/drawn_tags.hpp"

namespace divemesh::markers {
namespace {

// A recording of pairs that see a tag, each with its own time between the exposures.
class TagRecording : public synthetic::SensorRecording {
public:
    explicit TagRecording(std::vector<double> right_delays_s)
        : right_delays_s_(std::move(right_delays_s)) {
        its_rig = synthetic::ideal_cameras(synthetic::ideal_rig(640, 480, 500.0));
    }

    std::optional<types::StereoFrame> next_frame() override {
        if (next_ == std::ssize(right_delays_s_)) return std::nullopt;
        const Eigen::Isometry3d T_world_cam = looking_at_origin(0.6, 0.3, 0.0);
        const Eigen::Translation3d to_right(test_rig().baseline_m, 0.0, 0.0);
        types::StereoFrame frame;
        frame.index = static_cast<int>(next_);
        frame.left = draw({DrawnTag{}}, T_world_cam, test_rig());
        frame.right = draw({DrawnTag{}}, T_world_cam * to_right, test_rig());
        frame.right_delay_s = right_delays_s_[static_cast<std::size_t>(next_++)];
        return frame;
    }
    void rewind() override { next_ = 0; }

private:
    std::vector<double> right_delays_s_;
    std::ptrdiff_t next_ = 0;
};

TEST(FindTagsInTest, ARightImageOfAnotherTimeIsNotRead) {
    TagRecording recording({0.0, 0.02, -0.02, 1e-4});
    std::vector<types::Keyframe> keyframes(4);
    for (int i = 0; i < 4; ++i) keyframes[static_cast<std::size_t>(i)].frame_index = i;

    const auto views =
        find_tags_in(recording, keyframes, dive::MarkerFamily::Tag36h11, nullptr, {}, 1);

    for (std::size_t k = 0; k < 4; ++k)
        for (const bool is_right : {false, true})
            EXPECT_EQ(std::ranges::count_if(views,
                                            [&](const TagView& view) {
                                                return view.keyframe == k &&
                                                       view.is_right == is_right;
                                            }),
                      is_right && (k == 1 || k == 2) ? 0 : 1)
                << k << (is_right ? " right" : " left");
}

}  // namespace
}  // namespace divemesh::markers
