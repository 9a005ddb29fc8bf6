#pragma once

#include <Eigen/Geometry>
#include <optional>
#include <vector>

#include "sensor/preview_maker.hpp"
#include "worker/geometry/rectifier.hpp"
#include "worker/steps/track_features.hpp"
#include "worker/steps/with_depth_at_both_times.hpp"

namespace divemesh::sensor {

// Steps 2 to 6 of the method by vision alone, over two frames that follow each other, now and then:
// how fast the camera moves, and so how far it has, and how far a reconstruction would be off in
// the end by what each of its frames can be off, before it closes loops.
class QuickOdometry {
public:
    explicit QuickOdometry(const worker::Rig& rig);

    // Pictures CV_8UC1 as recorded and calibrated.
    void add(const worker::StereoFrame& before, const worker::StereoFrame& now);

    double distance_m() const { return distance_m_; }
    double expected_drift_m() const;
    int num_pairs() const { return num_pairs_; }  // of frames
    int num_lost() const { return num_lost_; }    // of them, whose motion was not found
    int num_tracked() const { return static_cast<int>(tracks_.size()); }
    const worker::Features& features() const { return features_; }
    const std::vector<TrackLine>& tracks() const { return tracks_; }
    const cv::Mat& picture() const { return picture_; }

private:
    void advance(const Eigen::Isometry3d& T_current_previous,
                 const worker::PointPairs& pairs,
                 double interval_s,
                 double num_steps);
    void show(const worker::PointPairs& pairs);
    Eigen::Isometry3d expected(double interval_s) const;

    worker::Rectifier rectifier_;
    worker::FeatureTracker tracker_;
    worker::Features features_;
    std::vector<TrackLine> tracks_;
    cv::Mat picture_;
    std::int64_t last_ns_ = 0;                                 // of the last motion that was found
    Eigen::Vector3d velocity_cam_ = Eigen::Vector3d::Zero();   // m/s, of T_current_previous
    Eigen::Vector3d turn_rate_cam_ = Eigen::Vector3d::Zero();  // rad/s
    double distance_m_ = 0.0;
    double position_variance_m2_ = 0.0;  // of the steps, each for itself
    double heading_variance_rad2_ = 0.0;
    double heading_drift_m_ = 0.0;  // what wrong headings have done to the steps since
    int num_pairs_ = 0;
    int num_lost_ = 0;
};

}  // namespace divemesh::sensor
