#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>

#include "tests/temporary_folder.hpp"
#include "worker/dive/dive.hpp"
#include "worker/geometry/rectifier.hpp"
#include "worker/reconstruct.hpp"
#include "worker/simulator/simulate.hpp"

namespace divemesh::worker {
namespace {

// Of the pixels with depth in what is handed on to the fusion.
struct Shares {
    double of_fish = 0.0;
    double of_scene = 0.0;
};

Shares shares_with_depth(const std::filesystem::path& dive,
                         const Rectifier& rectifier,
                         const Track& track,
                         const KeyframeStore& store) {
    std::int64_t fish = 0;
    std::int64_t fish_kept = 0;
    std::int64_t scene = 0;
    std::int64_t scene_kept = 0;
    for (const Keyframe& frame : track.mapped) {
        const auto name = std::to_string(frame.timestamp_ns) + ".png";
        const cv::Mat mask = rectifier.rectify_left(
            cv::imread((dive / "truth/cam0/fish" / name).string(), cv::IMREAD_GRAYSCALE));
        const cv::Mat known = store.read(frame.frame_index).depth.disparity_px > 0.0F;
        const cv::Mat is_fish = mask > 127;
        const cv::Mat is_scene = mask == 0;
        fish += cv::countNonZero(is_fish);
        fish_kept += cv::countNonZero(is_fish & known);
        scene += cv::countNonZero(is_scene);
        scene_kept += cv::countNonZero(is_scene & known);
    }
    return {static_cast<double>(fish_kept) / static_cast<double>(fish),
            static_cast<double>(scene_kept) / static_cast<double>(scene)};
}

// What no feature lies on, or lies on for less than two frames, is left to the fusion, which asks
// for several views of a surface.
TEST(MovingThingsTest, MuchOfTheFishIsLeftOutOfTheDepthThatIsFused) {
    const TemporaryFolder folder;
    const std::filesystem::path dive_folder = folder / "dive";
    simulate({.scene = SceneKind::Barge,
              .out = dive_folder,
              .length_m = 2.0,
              .seed = 3,
              .truth = true,
              .snow = false,
              .caustics = false,
              .width_px = 320,
              .height_px = 240});
    const auto dive = Dive::open(dive_folder, folder / "scratch");
    const KeyframeStore store(folder / "keyframes");

    const Track track = worker::track(
        *dive, make_options("standard", nlohmann::json::object()), store, ignore_progress);

    const Shares shares = shares_with_depth(dive_folder, Rectifier(dive->rig()), track, store);
    EXPECT_LT(shares.of_fish, 0.7 * shares.of_scene);
    EXPECT_GT(shares.of_scene, 0.8);
}

}  // namespace
}  // namespace divemesh::worker
