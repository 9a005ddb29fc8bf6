#include "worker/metrics/report.hpp"

#include <cstdint>
#include <cstdio>
#include <utility>
#include <vector>

#include "worker/metrics/svg_plot.hpp"

namespace divemesh::worker {
namespace {

using nlohmann::json;

constexpr char kStyle[] = R"(
body{font:15px/1.5 system-ui,sans-serif;color:#1b2a33;max-width:1180px;margin:2rem auto;padding:0 1rem}
h1{font-size:1.5rem;margin:0}h2{font-size:1.1rem;margin:1.6rem 0 .4rem}.sub{color:#5b6b75}
.row{display:flex;flex-wrap:wrap;gap:1.5rem;align-items:flex-start}.row>*{flex:1 1 340px;min-width:0}
table{border-collapse:collapse;width:100%}td,th{padding:.22rem .6rem;border-bottom:1px solid #dfe6ea;text-align:left;vertical-align:top}
td.value{text-align:right;font-variant-numeric:tabular-nums;white-space:nowrap}
svg{width:100%;height:auto;border:1px solid #dfe6ea;border-radius:4px}svg text{font:11px system-ui,sans-serif;fill:#415059}
svg .title{font-size:13px;font-weight:600;fill:#1b2a33}svg .grid{stroke:#e4eaee}
img{max-width:100%;border:1px solid #dfe6ea;border-radius:4px;background:#fff}
.error{color:#a3231f}.warning{color:#8a5a00}.info{color:#2f5d7c})";

using Rows = std::vector<std::pair<std::string, std::string>>;

// A figure by its path in metrics.json, scaled to what a person reads: "" when it is not there.
class Figures {
public:
    explicit Figures(const json& metrics) : metrics_(metrics) {}

    void add(Rows& rows,
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
    std::string text(const char* path) const {
        return metrics_.value(json::json_pointer(path), std::string());
    }

private:
    const json& metrics_;
};

std::string table(const std::string& title, const Rows& rows) {
    if (rows.empty()) return "";
    std::string html = "<section><h2>" + escape_html(title) + "</h2><table>";
    for (const auto& [name, value] : rows)
        html += "<tr><td>" + escape_html(name) + "</td><td class=\"value\">" + escape_html(value) +
                "</td></tr>";
    return html + "</table></section>";
}

Rows accuracy_rows(const Figures& figures) {
    Rows rows;
    figures.add(
        rows, "Trajectory error (ATE), RMS", "/trajectory/final/ate_rmse_m", "%.1f mm", 1e3);
    figures.add(rows, "Trajectory error, median", "/trajectory/final/ate_median_m", "%.1f mm", 1e3);
    figures.add(rows, "Trajectory error, largest", "/trajectory/final/ate_max_m", "%.1f mm", 1e3);
    figures.add(
        rows, "Without hindsight (causal), RMS", "/trajectory/causal/ate_rmse_m", "%.1f mm", 1e3);
    figures.add(rows, "Drift over segments", "/trajectory/final/drift_percent", "%.2f %%");
    figures.add(rows, "Drift at the end", "/trajectory/final/end_drift_percent", "%.2f %% of path");
    figures.add(rows, "Scale of the trajectory", "/trajectory/final/sim3_scale", "%.4f");
    figures.add(rows, "Known distances measured", "/known_distances/num_measured", "%.0f");
    figures.add(
        rows, "Scale error by known distances", "/known_distances/scale_error", "%+.2f %%", 1e2);
    figures.add(rows,
                "Known distances, median error",
                "/known_distances/median_abs_error_m",
                "%.1f mm",
                1e3);
    figures.add(rows, "Mesh accuracy, median", "/surface/accuracy/median_m", "%.1f mm", 1e3);
    figures.add(rows,
                "Mesh error over range, median",
                "/surface/relative_accuracy/median_percent",
                "%.2f %%");
    figures.add(rows, "Mesh accuracy, RMS", "/surface/accuracy/rms_m", "%.1f mm", 1e3);
    figures.add(
        rows, "Mesh completeness, median", "/surface/completeness/median_m", "%.1f mm", 1e3);
    figures.add(rows, "F1 at 10 mm", "/surface/scores/1/f1", "%.1f %%", 1e2);
    figures.add(rows, "F1 at 20 mm", "/surface/scores/2/f1", "%.1f %%", 1e2);
    return rows;
}

Rows dive_rows(const Figures& figures) {
    Rows rows;
    figures.add(rows, "Duration", "/dive/duration_s", "%.1f s");
    figures.add(rows, "Path", "/trajectory/path_length_m", "%.2f m");
    figures.add(rows, "Frames", "/frames/num_frames", "%.0f");
    figures.add(rows, "Frames that did not decode", "/frames/num_skipped_frames", "%.0f");
    figures.add(rows, "Frames tracked by vision", "/frames/coverage", "%.1f %%", 1e2);
    figures.add(rows, "Keyframes", "/frames/num_keyframes", "%.0f");
    figures.add(rows, "Baseline", "/calibration/baseline_m", "%.4f m");
    figures.add(rows, "Focal length", "/calibration/focal_px/0", "%.1f px");
    figures.add(rows, "Gravity as measured", "/calibration/gravity/magnitude_m_s2", "%.3f m/s²");
    figures.add(rows, "Tilt of gravity", "/calibration/gravity/tilt_deg", "%.2f°");
    figures.add(rows,
                "IMU clock ahead of the cameras",
                "/calibration/refined/time_offset_s/value",
                "%.2f ms",
                1e3);
    figures.add(
        rows, "Its standard deviation", "/calibration/refined/time_offset_s/sigma", "%.2f ms", 1e3);
    figures.add(rows,
                "IMU turned against the calibration",
                "/calibration/refined/rotation_deg/angle",
                "%.2f°");
    figures.add(rows,
                "Bending of the pictures that the calibration misses",
                "/calibration/refined/lenses/shift_px",
                "%.2f px");
    return rows;
}

Rows result_rows(const Figures& figures) {
    Rows rows;
    figures.add(rows, "Mesh area", "/mesh/area_m2", "%.2f m²");
    figures.add(rows, "Triangles", "/mesh/num_triangles", "%.0f");
    figures.add(rows, "Lost by simplifying, largest", "/mesh/simplification/max_m", "%.1f mm", 1e3);
    figures.add(rows, "Holes", "/mesh/num_holes", "%.0f");
    figures.add(rows, "Area of the holes", "/mesh/hole_area_m2", "%.3f m²");
    figures.add(rows, "Voxel", "/mesh/voxel_m", "%.1f mm", 1e3);
    figures.add(rows, "Features tracked, mean", "/tracking/mean_tracked_features", "%.0f");
    figures.add(rows, "Inliers", "/tracking/inlier_share", "%.1f %%", 1e2);
    figures.add(
        rows, "Gyro against vision", "/tracking/imu_vision_disagreement_deg", "%.3f° a frame");
    figures.add(rows, "Reprojection error, RMS", "/tracking/reprojection_rms_px", "%.2f px");
    figures.add(rows, "Speed", "/speed/frames_per_s", "%.1f frames/s");
    figures.add(rows, "Peak memory", "/speed/peak_memory_bytes", "%.0f MB", 1e-6);
    return rows;
}

Plot top_view(const ReportInput& input) {
    Plot plot{"Path from above", "x, m", "y, m", {}, true};
    const auto line = [](const std::string& name, const std::string& color, const auto& positions) {
        PlotLine result{name, color, {}, {}};
        for (const Eigen::Vector3d& position : positions) {
            result.x.push_back(position.x());
            result.y.push_back(position.y());
        }
        return result;
    };
    if (input.evaluation.trajectory) {
        plot.lines = {line("truth", "#9aa7af", input.evaluation.trajectory->reference),
                      line("estimate", "#0b6fa4", input.evaluation.trajectory->aligned)};
        return plot;
    }
    std::vector<Eigen::Vector3d> positions;
    for (const StampedPose& pose : input.trajectory)
        positions.push_back(pose.T_world_imu.translation());
    plot.lines = {line("estimate", "#0b6fa4", positions)};
    return plot;
}

double seconds_since(std::int64_t start_ns, std::int64_t time_ns) {
    return static_cast<double>(time_ns - start_ns) * 1e-9;
}

// With truth: the error over time. Without: how high the rig was.
Plot over_time(const ReportInput& input) {
    if (const auto& error = input.evaluation.trajectory) {
        PlotLine line{"after alignment", "#b3541e", {}, {}};
        for (std::size_t i = 0; i < error->aligned.size(); ++i) {
            line.x.push_back(seconds_since(error->timestamps_ns.front(), error->timestamps_ns[i]));
            line.y.push_back((error->aligned[i] - error->reference[i]).norm() * 1e3);
        }
        return {"Position error", "time, s", "error, mm", {line}};
    }
    PlotLine line{"z of the rig", "#b3541e", {}, {}};
    for (const StampedPose& pose : input.trajectory) {
        line.x.push_back(seconds_since(input.trajectory.front().timestamp_ns, pose.timestamp_ns));
        line.y.push_back(pose.T_world_imu.translation().z());
    }
    return {"Height over the start", "time, s", "z, m", {line}};
}

std::string base64(const std::string& bytes) {
    constexpr char kDigits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    std::string text;
    for (std::size_t i = 0; i < bytes.size(); i += 3) {
        std::uint32_t group = 0;
        for (std::size_t k = 0; k < 3; ++k)
            group =
                group << 8 | (i + k < bytes.size() ? static_cast<std::uint8_t>(bytes[i + k]) : 0U);
        for (std::size_t k = 0; k < 4; ++k)
            text += i + k > bytes.size() ? '=' : kDigits[group >> (18 - 6 * k) & 63U];
    }
    return text;
}

std::string findings(const json& metrics) {
    const json list = metrics.value("findings", json::array());
    if (list.empty()) return "<p>None.</p>";
    std::string html = "<table>";
    for (const json& finding : list) {
        const auto text = [&](const char* key) {
            return escape_html(finding.value(key, std::string()));
        };
        html += "<tr><td class=\"" + text("severity") + "\">" + text("severity") + "</td><td>" +
                text("where") + "</td><td>" + text("message") + "</td><td>" + text("remedy") +
                "</td></tr>";
    }
    return html + "</table>";
}

}  // namespace

std::string report_html(const ReportInput& input) {
    const Figures figures(input.metrics);
    std::string name = figures.text("/dive/name");
    if (name.empty()) name = "dive " + figures.text("/dive/content_sha256").substr(0, 12);
    std::string html = "<!doctype html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"><title>" +
                       escape_html(name) + "</title><style>" + kStyle +
                       "</style></head><body><h1>" + escape_html(name) +
                       "</h1><p class=\"sub\">divemesh " + escape_html(figures.text("/version")) +
                       ", preset " + escape_html(figures.text("/preset")) +
                       "</p><div class=\"row\">";
    if (!input.picture_png.empty())
        html +=
            "<section><h2>From above</h2><img alt=\"The mesh from above\" "
            "src=\"data:image/png;base64," +
            base64(input.picture_png) + "\"></section>";
    html += table("Against the truth", accuracy_rows(figures)) + "</div><div class=\"row\">" +
            svg_plot(top_view(input)) + svg_plot(over_time(input)) + "</div><div class=\"row\">" +
            table("The dive", dive_rows(figures)) + table("The result", result_rows(figures)) +
            "</div><h2>Findings</h2>" + findings(input.metrics) + "</body></html>\n";
    return html;
}

}  // namespace divemesh::worker
