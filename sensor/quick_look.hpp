#pragma once

#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <opencv2/core/mat.hpp>
#include <vector>

#include "sensor/dive_tail.hpp"
#include "sensor/picture_check.hpp"
#include "sensor/preview_maker.hpp"
#include "sensor/quick_odometry.hpp"

namespace divemesh::sensor {

// A first look at a dive while it is made, from two frames now and then: whether it is worth
// keeping. With the calibration of both cameras beside the pictures the features are followed and
// the way that was swum is measured by stereo alone; without it they are only counted.
class QuickLook {
public:
    explicit QuickLook(const std::filesystem::path& dive_root);
    ~QuickLook();

    // Two frames that follow each other, and what a picture of late was measured to be; some tens
    // of milliseconds.
    void look(const FramePictures& before, const FramePictures& now, const PictureQuality& quality);

    // "features", "coverage" (share of a grid of the picture that has some), "mean_level",
    // "black", "bright", "sharpness", and once it is measured "tracked", "distance_m",
    // "expected_drift_m" (one standard deviation of where this track ends; a reconstruction,
    // which sees every frame, drifts less), "lost" (looks without a motion), "pairs" (looks).
    nlohmann::json report() const;

    // The track; null before it is begun.
    const QuickOdometry* odometry() const;
    // The last picture as it was measured, and what was followed in it; for a preview.
    cv::Mat picture() const;
    const std::vector<TrackLine>& tracks() const;

private:
    struct Implementation;
    std::unique_ptr<Implementation> implementation_;
};

}  // namespace divemesh::sensor
