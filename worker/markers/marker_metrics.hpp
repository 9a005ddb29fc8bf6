#pragma once

#include <Eigen/Geometry>
#include <array>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "schemas/finding.hpp"
#include "worker/dive/marker_plan.hpp"

namespace divemesh::markers {

// Covariance of the corners of a marker against each other, x y z of each in the order of
// TagCorner, m^2.
using CornerCovariance = Eigen::Matrix<double, 12, 12>;

// A marker as triangulated. Frame `marker`: origin in the middle, x to the right and y up as the
// tag is read, z out of its face.
struct Marker {
    int id = 0;
    std::int32_t segment = 0;
    int num_views = 0;           // pictures, left and right, that it was measured in
    int num_keyframes = 0;       // of these
    int num_rejected_views = 0;  // where the id was read, but not in this place
    std::array<Eigen::Vector3d, dive::kNumTagCorners> corners_world;
    Eigen::Isometry3d T_world_marker = Eigen::Isometry3d::Identity();
    double reprojection_rms_px = 0.0;                                  // of both axes
    double range_m = 0.0;                                              // median, from the camera
    double pixel_m = 0.0;                                              // what a pixel covers there
    CornerCovariance corner_covariance_m2 = CornerCovariance::Zero();  // for the poses as they are
    // Of the poses that it was seen from, carried over to the middle; m^2, axes of the world.
    Eigen::Matrix3d drift_covariance_m2 = Eigen::Matrix3d::Zero();
    double path_m = 0.0;  // how far the rig had swum, mean over the views

    Eigen::Vector3d point(const std::optional<dive::TagCorner>& corner) const;  // else the middle
    std::array<double, dive::kNumTagCorners> edges_m() const;  // bottom, right, top, left
    Eigen::Matrix3d covariance_m2() const;                     // of the middle, all in all
};

// A known distance and what became of it. Errors are measured minus known.
struct BarMetrics {
    std::string name;
    bool is_printed_size = false;  // of one tag, mean of its edges
    dive::MarkerPoint from;
    dive::MarkerPoint to;
    double known_m = 0.0;
    double known_sigma_m = 0.0;
    std::optional<double> measured_m;  // nothing: an end was not found
    // What dark edges do that look farther in than they are, as bright light spreads and tone
    // curves have it: the same for all tags. Part of own_sigma_m.
    double edge_sigma_m = 0.0;
    double own_sigma_m = 0.0;  // without what all bars share, the scale of the reconstruction
    double sigma_m = 0.0;      // with the scale of the reconstruction, shared by all
    // The others' scale taken for this one; nothing without others.
    std::optional<double> leave_one_out_error_m;
    double leave_one_out_sigma_m = 0.0;

    bool consistent = false;  // with the others; with fewer than three nobody can tell

    double error_m() const { return *measured_m - known_m; }
    double leave_one_out_sigmas() const;  // 0 without others
};

// known = factor * measured, over all bars.
struct MarkerScale {
    double factor = 1.0;
    double sigma = 0.0;  // widened when the bars disagree by more than they should
    int num_bars = 0;
    std::vector<std::string> bars;  // that it was made from
};

// By what the whole result was made larger or smaller.
struct ScaleCorrection {
    bool applied = false;
    MarkerScale scale;  // as measured before; when applied
};

struct MarkerMetrics {
    dive::MarkerFamily family = dive::MarkerFamily::Tag36h11;
    std::vector<Marker> markers;  // by piece, then id
    std::vector<BarMetrics> bars;
    std::optional<MarkerScale> scale;  // nothing: no bar was measured
    double systematic_scale_sigma = 0.0;
    std::optional<ScaleCorrection> correction;  // nothing: not asked for
    std::vector<Finding> findings;
};

nlohmann::json to_metrics(const MarkerMetrics& metrics);

}  // namespace divemesh::markers
