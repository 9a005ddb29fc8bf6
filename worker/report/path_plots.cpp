#include "worker/report/path_plots.hpp"

#include <Eigen/Geometry>
#include <string>

#include "worker/base/seconds.hpp"

namespace divemesh::report {
namespace {

constexpr char kTruthColor[] = "#9aa7af";
constexpr char kEstimateColor[] = "#0b6fa4";
constexpr char kErrorColor[] = "#b3541e";

struct Paths {
    std::vector<Eigen::Vector3d> truth;  // empty: no truth
    std::vector<Eigen::Vector3d> estimate;
};

Paths paths_of(const evaluation::TrajectoryError* error, const types::Trajectory& path) {
    if (error != nullptr) return {error->reference, error->aligned};
    Paths paths;
    for (const types::StampedPose& pose : path)
        paths.estimate.push_back(pose.T_world_imu.translation());
    return paths;
}

PlotLine line_of(const std::string& name,
                 const std::string& color,
                 const std::vector<Eigen::Vector3d>& positions,
                 int x_axis,
                 int y_axis) {
    PlotLine line{name, color, {}, {}};
    for (const Eigen::Vector3d& position : positions) {
        line.x.push_back(position[x_axis]);
        line.y.push_back(position[y_axis]);
    }
    return line;
}

Plot view(const std::string& title, const Paths& paths, int x_axis, int y_axis) {
    const char* labels[] = {"x, m", "y, m", "z, m"};
    Plot plot{title, labels[x_axis], labels[y_axis], {}, true};
    if (!paths.truth.empty())
        plot.lines.push_back(line_of("truth", kTruthColor, paths.truth, x_axis, y_axis));
    plot.lines.push_back(line_of("estimate", kEstimateColor, paths.estimate, x_axis, y_axis));
    return plot;
}

double seconds_since(std::int64_t start_ns, std::int64_t time_ns) {
    return base::to_s(time_ns - start_ns);
}

}  // namespace

Plot path_from_above(const evaluation::TrajectoryError* error, const types::Trajectory& path) {
    return view("Path from above", paths_of(error, path), 0, 1);
}

Plot path_from_the_side(const evaluation::TrajectoryError* error, const types::Trajectory& path) {
    const Paths paths = paths_of(error, path);
    Eigen::AlignedBox3d box;
    for (const Eigen::Vector3d& position : paths.estimate) box.extend(position);
    const bool is_long_in_y = !box.isEmpty() && box.sizes().y() > box.sizes().x();
    return view("Path from the side", paths, is_long_in_y ? 1 : 0, 2);
}

Plot error_over_time(const evaluation::TrajectoryError* error, const types::Trajectory& path) {
    if (error != nullptr) {
        PlotLine line{"after alignment", kErrorColor, {}, {}};
        for (std::size_t i = 0; i < error->aligned.size(); ++i) {
            line.x.push_back(seconds_since(error->timestamps_ns.front(), error->timestamps_ns[i]));
            line.y.push_back((error->aligned[i] - error->reference[i]).norm() * 1e3);
        }
        return {"Position error", "time, s", "error, mm", {line}};
    }
    PlotLine line{"z of the rig", kErrorColor, {}, {}};
    for (const types::StampedPose& pose : path) {
        line.x.push_back(seconds_since(path.front().timestamp_ns, pose.timestamp_ns));
        line.y.push_back(pose.T_world_imu.translation().z());
    }
    return {"Height over the start", "time, s", "z, m", {line}};
}

Plot error_by_segment(const evaluation::TrajectoryError& error) {
    PlotLine mean{"mean", kEstimateColor, {}, {}};
    PlotLine rmse{"root mean square", kErrorColor, {}, {}};
    for (const evaluation::SegmentError& segment : error.segments) {
        mean.x.push_back(segment.length_m);
        rmse.x.push_back(segment.length_m);
        mean.y.push_back(segment.translation_mean_percent);
        rmse.y.push_back(segment.translation_rmse_percent);
    }
    return {"Relative error by segment length", "length, m", "error, %", {mean, rmse}};
}

}  // namespace divemesh::report
