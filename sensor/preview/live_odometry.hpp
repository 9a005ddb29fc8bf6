#pragma once

#include <Eigen/Geometry>
#include <optional>
#include <vector>

#include "sensor/preview/preview_maker.hpp"
#include "worker/camera/rectifier.hpp"
#include "worker/features/track_features.hpp"
#include "worker/odometry/with_depth_at_both_times.hpp"

namespace divemesh::sensor {

// A sparse track by vision alone. Now and then steps 2 to 6 of the method over two consecutive
// frames (an assessment) give the camera's motion. Between two assessments the motion is taken as
// the mean of both. It also estimates its error: from the uncertainty of each assessment, and from
// how much the camera's motion varies.
class LiveOdometry {
public:
    explicit LiveOdometry(const types::Rig& rig);

    // Adds an assessment. Images are CV_8UC1, as recorded and calibrated.
    void add(const types::StereoFrame& before, const types::StereoFrame& now);

    // Up to the last assessment whose motion was found.
    double distance_m() const { return distance_m_; }
    const Eigen::Isometry3d& T_first_current() const { return T_first_current_; }
    // Returns one standard deviation of the position, over all three directions together, m.
    double expected_drift_m() const;
    int num_assessments() const { return num_assessments_; }
    int num_lost() const { return num_lost_; }  // assessments whose motion was not found
    int num_tracked() const { return static_cast<int>(tracks_.size()); }
    const types::RectifiedRig& rig() const { return rectifier_.rig(); }
    const types::Features& features() const { return features_; }
    const std::vector<TrackLine>& tracks() const { return tracks_; }
    const cv::Mat& image() const { return image_; }

private:
    using Matrix6d = Eigen::Matrix<double, 6, 6>;
    using Vector6d = Eigen::Matrix<double, 6, 1>;

    // Motion at an assessment: rotation, then translation, of T_current_previous, per second.
    struct Motion {
        std::int64_t timestamp_ns = 0;
        Vector6d rate;        // rad/s, m/s
        Matrix6d covariance;  // of `rate`
        double speed_m_s() const;
    };

    odometry::PointPairs follow(const types::StereoFrame& before,
                                const types::StereoFrame& now,
                                const Eigen::Isometry3d& guess);
    void advance(const Motion& from, const Motion& to);
    void learn_unrest(const Motion& before, const Motion& middle, const Motion& after);
    void add_error(const Eigen::Isometry3d& T_current_previous, const Matrix6d& covariance);
    void show(const odometry::PointPairs& pairs);

    camera::Rectifier rectifier_;
    features::FeatureTracker tracker_;
    types::Features features_;
    std::vector<TrackLine> tracks_;
    cv::Mat image_;
    std::optional<Motion> motion_;  // the last one found
    std::optional<Motion> motion_before_;
    Eigen::Isometry3d T_first_current_ = Eigen::Isometry3d::Identity();
    Matrix6d covariance_ = Matrix6d::Zero();  // rotation, then position, in the first frame
    Vector6d unrest_ = Vector6d::Zero();      // sum over num_changes_ of q, rad^2/s^3 and m^2/s^3
    int num_changes_ = 0;
    double distance_m_ = 0.0;
    int num_assessments_ = 0;
    int num_lost_ = 0;
};

}  // namespace divemesh::sensor
