#include "worker/report/metric_rows.hpp"

#include <cstdio>

namespace divemesh::report {
namespace {

using nlohmann::json;

// Adds a row for a metric by its path in metrics.json, scaled to a readable unit; no row if it is
// missing.
class MetricReader {
public:
    explicit MetricReader(const json& metrics) : metrics_(metrics) {}

    void add(HtmlRows& rows,
             const std::string& name,
             const char* path,
             const char* format,
             double factor = 1.0) const {
        const json::json_pointer pointer(path);
        if (!metrics_.contains(pointer) || !metrics_[pointer].is_number()) return;
        char text[64];
        std::snprintf(text, sizeof text, format, metrics_[pointer].get<double>() * factor);
        rows.emplace_back(name, text);
    }

private:
    const json& metrics_;
};

}  // namespace

HtmlRows accuracy_rows(const json& metrics) {
    const MetricReader reader(metrics);
    HtmlRows rows;
    reader.add(rows, "Trajectory error (ATE), RMS", "/trajectory/final/ate_rmse_m", "%.1f mm", 1e3);
    reader.add(rows, "Trajectory error, median", "/trajectory/final/ate_median_m", "%.1f mm", 1e3);
    reader.add(rows, "Trajectory error, max", "/trajectory/final/ate_max_m", "%.1f mm", 1e3);
    reader.add(
        rows, "Without hindsight (causal), RMS", "/trajectory/causal/ate_rmse_m", "%.1f mm", 1e3);
    reader.add(rows, "Drift over segments", "/trajectory/final/drift_percent", "%.2f %%");
    reader.add(rows, "Drift at the end", "/trajectory/final/end_drift_percent", "%.2f %% of path");
    reader.add(rows, "Scale of the trajectory", "/trajectory/final/sim3_scale", "%.4f");
    reader.add(rows, "Known distances measured", "/known_distances/num_measured", "%.0f");
    reader.add(
        rows, "Scale error from known distances", "/known_distances/scale_error", "%+.2f %%", 1e2);
    reader.add(rows,
               "Known distances, median error",
               "/known_distances/median_abs_error_m",
               "%.1f mm",
               1e3);
    reader.add(rows, "Mesh accuracy, median", "/surface/accuracy/median_m", "%.1f mm", 1e3);
    reader.add(rows,
               "Mesh error over range, median",
               "/surface/relative_accuracy/median_percent",
               "%.2f %%");
    reader.add(rows, "Mesh accuracy, RMS", "/surface/accuracy/rms_m", "%.1f mm", 1e3);
    reader.add(rows, "Mesh completeness, median", "/surface/completeness/median_m", "%.1f mm", 1e3);
    reader.add(rows, "F1 at 10 mm", "/surface/scores/1/f1", "%.1f %%", 1e2);
    reader.add(rows, "F1 at 20 mm", "/surface/scores/2/f1", "%.1f %%", 1e2);
    reader.add(rows,
               "Reference seen by three pairs, within 20 mm of the mesh",
               "/surface/share_20mm",
               "%.1f %%",
               1e2);
    reader.add(rows,
               "Mesh farther than 50 mm from the reference",
               "/surface/false_share_50mm",
               "%.1f %%",
               1e2);
    return rows;
}

HtmlRows expected_rows(const json& metrics) {
    const MetricReader reader(metrics);
    const std::string section = "/expected_accuracy/";
    HtmlRows rows;
    const auto add = [&](const char* name, const char* metric, const char* format, double factor) {
        reader.add(rows, name, (section + metric).c_str(), format, factor);
    };
    add("Trajectory error (ATE), 95 % below", "trajectory/ate/bound_m", "%.1f mm", 1e3);
    add("Last position, 95 % below", "trajectory/end_position/bound_m", "%.1f mm", 1e3);
    add("Remaining error of the loops", "trajectory/loops/residual_rms_m", "%.1f mm", 1e3);
    add("Scale from the accelerometer", "scale/accelerometer/scale", "%.3f", 1.0);
    add("Its standard deviation", "scale/accelerometer/sigma", "%.3f", 1.0);
    add("Scale from the pressure", "scale/pressure/scale", "%.3f", 1.0);
    add("Its standard deviation", "scale/pressure/sigma", "%.3f", 1.0);
    add("Scale from positions", "scale/positions/scale", "%.4f", 1.0);
    add("Its standard deviation", "scale/positions/sigma", "%.4f", 1.0);
    add("Scale from known distances", "scale/known_distances/scale", "%.4f", 1.0);
    add("Its standard deviation", "scale/known_distances/sigma", "%.4f", 1.0);
    add("Surface error, 95 % below", "surface/error_95_m", "%.1f mm", 1e3);
    add("Surface sigma, median", "surface/sigma_median_m", "%.1f mm", 1e3);
    add("Surface seen from 3 frames or more", "surface/share_3_views_or_more", "%.1f %%", 1e2);
    return rows;
}

HtmlRows dive_rows(const json& metrics) {
    const MetricReader reader(metrics);
    HtmlRows rows;
    reader.add(rows, "Duration", "/dive/duration_s", "%.1f s");
    reader.add(rows, "Path", "/trajectory/path_length_m", "%.2f m");
    reader.add(rows, "Easting of the first pose (UTM)", "/georeference/easting_m", "%.2f m");
    reader.add(rows, "Its standard deviation", "/georeference/easting_sigma_m", "%.2f m");
    reader.add(rows, "Northing of the first pose (UTM)", "/georeference/northing_m", "%.2f m");
    reader.add(rows, "Its standard deviation", "/georeference/northing_sigma_m", "%.2f m");
    reader.add(rows, "Azimuth of the x axis", "/georeference/x_azimuth_deg", "%.2f°");
    reader.add(rows, "Its standard deviation", "/georeference/heading_sigma_deg", "%.2f°");
    reader.add(rows, "Frames", "/frames/num_frames", "%.0f");
    reader.add(rows, "Frames that did not decode", "/frames/num_skipped_frames", "%.0f");
    reader.add(rows, "Frames tracked by vision", "/frames/coverage", "%.1f %%", 1e2);
    reader.add(rows, "Keyframes", "/frames/num_keyframes", "%.0f");
    reader.add(rows, "Baseline", "/calibration/baseline_m", "%.4f m");
    reader.add(rows, "Focal length", "/calibration/focal_px/0", "%.1f px");
    reader.add(rows, "Gravity as measured", "/calibration/gravity/magnitude_m_s2", "%.3f m/s²");
    reader.add(rows, "Tilt of gravity", "/calibration/gravity/tilt_deg", "%.2f°");
    reader.add(rows,
               "IMU clock ahead of the cameras",
               "/calibration/refined/time_offset_s/value",
               "%.2f ms",
               1e3);
    reader.add(
        rows, "Its standard deviation", "/calibration/refined/time_offset_s/sigma", "%.2f ms", 1e3);
    reader.add(rows,
               "IMU rotation from the calibration",
               "/calibration/refined/rotation_deg/angle",
               "%.2f°");
    reader.add(rows,
               "Lens distortion missing in the calibration",
               "/calibration/refined/lenses/shift_px",
               "%.2f px");
    return rows;
}

HtmlRows result_rows(const json& metrics) {
    const MetricReader reader(metrics);
    HtmlRows rows;
    reader.add(rows, "Mesh area", "/mesh/area_m2", "%.2f m²");
    reader.add(rows, "Triangles", "/mesh/num_triangles", "%.0f");
    reader.add(rows, "Error of simplification, max", "/mesh/simplification/max_m", "%.1f mm", 1e3);
    reader.add(rows, "Keyframe images covered by the mesh", "/mesh/covered_share", "%.0f %%", 1e2);
    reader.add(rows,
               "Surface measured by keyframes that is in the mesh",
               "/mesh/covered_share_of_matched",
               "%.0f %%",
               1e2);
    reader.add(rows, "Holes", "/mesh/num_holes", "%.0f");
    reader.add(rows, "Area of the holes", "/mesh/hole_area_m2", "%.3f m²");
    reader.add(rows, "Largest hole", "/mesh/largest_hole_m2", "%.3f m²");
    reader.add(rows, "Removed as small parts", "/mesh/small_components_m2", "%.3f m²");
    reader.add(rows, "Removed by max_sigma_m", "/mesh/cut_by_sigma_m2", "%.3f m²");
    reader.add(rows, "Voxel", "/mesh/voxel_m", "%.1f mm", 1e3);
    reader.add(rows, "Features tracked, mean", "/tracking/mean_tracked_features", "%.0f");
    reader.add(rows, "Inliers", "/tracking/inlier_share", "%.1f %%", 1e2);
    reader.add(
        rows, "Gyro against vision", "/tracking/imu_vision_disagreement_deg", "%.3f° a frame");
    reader.add(rows, "Reprojection error, RMS", "/tracking/reprojection_rms_px", "%.2f px");
    reader.add(rows, "Speed", "/speed/frames_per_s", "%.1f frames/s");
    reader.add(rows, "Peak memory", "/speed/peak_memory_bytes", "%.0f MB", 1e-6);
    return rows;
}

}  // namespace divemesh::report
