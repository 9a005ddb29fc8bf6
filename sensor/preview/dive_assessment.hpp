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

// A first look at a dive while it is made, from two frames now and then: whether it is worth
// keeping. With the calibration of both cameras beside the pictures the features are followed and
// the way that was swum is measured by stereo alone; without it they are only counted.
class DiveAssessment {
public:
    explicit DiveAssessment(const std::filesystem::path& dive_root);
    ~DiveAssessment();

    // Two frames that follow each other, and what a picture of late was measured to be; some tens
    // of milliseconds.
    void look(const FrameImages& before, const FrameImages& now, const ImageQuality& quality);

    // "features", "coverage" (share of a grid of the picture that has some), "mean_level",
    // "black", "bright", "sharpness", and once it is measured "tracked", "distance_m",
    // "expected_drift_m" (one standard deviation of where this track ends; a reconstruction,
    // which sees every frame, drifts less), "lost" (looks without a motion), "pairs" (looks).
    nlohmann::json report() const;

    // The track; null before it is begun.
    const LiveOdometry* odometry() const;
    // The last picture as it was measured, and what was followed in it; for a preview.
    cv::Mat image() const;
    const std::vector<TrackLine>& tracks() const;

private:
    struct Implementation;
    std::unique_ptr<Implementation> implementation_;
};

}  // namespace divemesh::sensor
