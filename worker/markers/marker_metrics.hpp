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

// Covariance of a marker's corners with each other: x y z of each in the order of TagCorner, m^2.
using CornerCovariance = Eigen::Matrix<double, 12, 12>;

// A triangulated marker. Frame `marker`: origin in the centre, x to the right and y up as the tag
// is read, z out of its face.
struct Marker {
    int id = 0;
    std::int32_t segment = 0;
    int num_views = 0;           // images, left and right, that it was measured in
    int num_keyframes = 0;       // that these images belong to
    int num_rejected_views = 0;  // with this id, but in another place
    std::array<Eigen::Vector3d, dive::kNumTagCorners> corners_world;
    Eigen::Isometry3d T_world_marker = Eigen::Isometry3d::Identity();
    double reprojection_rms_px = 0.0;  // over both axes
    double range_m = 0.0;              // median, from the camera
    double pixel_m = 0.0;              // size of a pixel at that range
    // With the poses taken as exact.
    CornerCovariance corner_covariance_m2 = CornerCovariance::Zero();
    // Covariance of the poses that it was seen from, propagated to the centre; m^2, world axes.
    Eigen::Matrix3d drift_covariance_m2 = Eigen::Matrix3d::Zero();
    double path_m = 0.0;  // path length up to its views, mean

    Eigen::Vector3d point(const std::optional<dive::TagCorner>& corner) const;  // nullopt: centre
    std::array<double, dive::kNumTagCorners> edges_m() const;  // bottom, right, top, left
    Eigen::Matrix3d covariance_m2() const;                     // of the centre, total
};

// A known distance and its measurement. Errors are measured minus known.
struct BarMetrics {
    std::string name;
    bool is_printed_size = false;  // of one tag, mean of its edges
    dive::MarkerPoint from;
    dive::MarkerPoint to;
    double known_m = 0.0;
    double known_sigma_m = 0.0;
    std::optional<double> measured_m;  // nullopt: an end was not found
    // Uncertainty from dark edges that appear farther inside than they are, because bright light
    // spreads and because of tone curves: the same for all tags. Part of own_sigma_m.
    double edge_sigma_m = 0.0;
    double own_sigma_m = 0.0;  // without the scale of the reconstruction, which all bars share
    double sigma_m = 0.0;      // with the scale of the reconstruction, which all bars share
    // Error with the scale of the other bars; nullopt if there are no others.
    std::optional<double> leave_one_out_error_m;
    double leave_one_out_sigma_m = 0.0;

    bool consistent = false;  // with the others; with fewer than three bars this cannot be decided

    double error_m() const { return *measured_m - known_m; }
    double leave_one_out_sigmas() const;  // 0 if there are no others
};

// Scale factor over all bars: known = factor * measured.
struct MarkerScale {
    double factor = 1.0;
    double sigma = 0.0;  // increased if the bars disagree by more than expected
    int num_bars = 0;
    std::vector<std::string> bars;  // bars that it was made from
};

// The scaling of the whole result.
struct ScaleCorrection {
    bool applied = false;
    MarkerScale scale;  // as measured before the scaling, if applied
};

// All results of the markers: markers, bars, scale and findings.
struct MarkerMetrics {
    dive::MarkerFamily family = dive::MarkerFamily::Tag36h11;
    std::vector<Marker> markers;  // by segment, then id
    std::vector<BarMetrics> bars;
    std::optional<MarkerScale> scale;  // nullopt: no bar was measured
    // The same by what was certainly measured: only this may scale the result automatically.
    std::optional<MarkerScale> trusted_scale;
    double systematic_scale_sigma = 0.0;
    std::optional<ScaleCorrection> correction;  // nullopt: not requested
    std::vector<Finding> findings;
};

nlohmann::json to_metrics(const MarkerMetrics& metrics);

}  // namespace divemesh::markers
