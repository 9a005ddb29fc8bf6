#pragma once

#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <opencv2/core/mat.hpp>
#include <vector>

#include "sensor/preview/image_check.hpp"
#include "sensor/preview/live_odometry.hpp"
#include "sensor/preview/preview_maker.hpp"
#include "sensor/recording/dive_tail.hpp"

namespace divemesh::sensor {

// Assesses a dive while it is recorded, from two frames now and then: whether it is worth keeping.
// With the calibration of both cameras beside the images it tracks features and measures the
// distance by stereo alone; without it, it only counts features.
class DiveAssessment {
public:
    explicit DiveAssessment(const std::filesystem::path& dive_root);
    ~DiveAssessment();

    // Adds two consecutive frames, with the quality of a recent image; takes tens of milliseconds.
    void add(const FrameImages& before, const FrameImages& now, const ImageQuality& quality);

    // Returns "features", "coverage" (share of a grid of the image that has some), "mean_level",
    // "black", "bright", "sharpness". Once measured also "tracked", "distance_m",
    // "expected_drift_m" (one standard deviation of the track's end; a reconstruction, which uses
    // every frame, drifts less), "lost" (assessments without a motion), "pairs" (assessments).
    nlohmann::json report() const;

    // Returns the track; null before it begins.
    const LiveOdometry* odometry() const;
    // Return the last measured image and the features tracked in it, for a preview.
    cv::Mat image() const;
    const std::vector<TrackLine>& tracks() const;

private:
    struct Implementation;
    std::unique_ptr<Implementation> implementation_;
};

}  // namespace divemesh::sensor
