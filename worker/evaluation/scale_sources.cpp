#include "worker/evaluation/scale_sources.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "worker/base/text.hpp"
#include "worker/evaluation/accelerometer_fit.hpp"
#include "worker/evaluation/imu_check.hpp"
#include "worker/imu/preintegration.hpp"
#include "worker/optimisation/expected_path_error.hpp"

namespace divemesh::evaluation {
namespace {

// Beyond it a check is not informative: path and sensor err by as much for reasons of their own.
constexpr double kMaxSigma = 0.05;
constexpr double kAccelerometerScaleSigma = 0.003;  // of the sensor itself
// By which a usual bias (0.1 m/s^2) changes the gravity that an accelerometer measures.
constexpr double kGravityByBias = 0.01;
// Recorders turn pressure into depth with the density that they are set to: fresh and sea water
// differ by 2.5 to 3 %.
constexpr double kPressureScaleSigma = 0.025;

// Returns the error of distant positions: they err independently, each by a third of the mean
// square along a line.
PathError path_error(const types::Trajectory& trajectory, const types::PathUncertainty& path) {
    Eigen::AlignedBox3d box;
    for (const types::StampedPose& pose : trajectory) box.extend(pose.T_world_imu.translation());
    return {std::numbers::sqrt2 * optimisation::shared_sigma_m(path),
            box.isEmpty() ? 0.0 : box.diagonal().norm()};
}

// Returns the error of the accelerometer's own scale. Where its gravity is wrong by more than a
// bias explains, its scale may be as wrong: its units, range or supply are not as calibrated.
double accelerometer_sigma(const std::vector<types::ImuSample>& imu,
                           const types::Trajectory& trajectory) {
    const auto gravity = check_gravity(imu, trajectory);
    if (!gravity) return kAccelerometerScaleSigma;
    const double wrong = std::abs(gravity->magnitude_m_s2 / imu::kGravity_m_s2 - 1.0);
    return std::hypot(kAccelerometerScaleSigma, std::max(0.0, wrong - kGravityByBias));
}

std::optional<ScaleCheck> by_known_distances(const LengthData& lengths, const PathError& path) {
    const auto marked = scale_by_marked_distances(lengths.marked_distances);
    if (marked || !lengths.known_distances) return marked;
    return scale_by_distances(*lengths.known_distances, path);
}

// Collects the checks.
class Collector {
public:
    // Adds a check whose source itself errs by `own_sigma`; `why_not` is the reason if there is
    // none.
    void add(const std::string& name,
             std::optional<ScaleCheck> check,
             double own_sigma,
             const std::string& why_not) {
        if (!check) return leave_out(name, why_not);
        if (own_sigma > kMaxSigma)
            return leave_out(
                name, "its gravity is wrong by about " + base::fixed(100.0 * own_sigma, 0) + " %");
        check->sigma = std::hypot(check->sigma, own_sigma);
        if (check->sigma > kMaxSigma)
            return leave_out(name,
                             "the motion determines too little: sigma would be " +
                                 base::fixed(100.0 * check->sigma, 1) + " % of the scale");
        result_.usable.push_back({name, *check});
    }
    void leave_out(const std::string& name, const std::string& reason) {
        result_.left_out.push_back({"scale." + name, reason});
    }
    ScaleSources take() { return std::move(result_); }

private:
    ScaleSources result_;
};

}  // namespace

double covariance_scale(const types::LoopStatistics& loops) {
    return loops.num_accepted > 0 ? std::max(1.0, loops.residual_sigmas) : 1.0;
}

std::vector<ScaleSource> against_path(std::vector<ScaleSource> sources,
                                      const types::PathUncertainty& path) {
    for (ScaleSource& source : sources)
        source.check.sigma = std::hypot(source.check.sigma, path.scale_sigma_or_typical());
    return sources;
}

double scale_contradiction(const std::vector<ScaleSource>& sources,
                           const types::PathUncertainty& path) {
    double largest = 0.0;
    for (const ScaleSource& source : against_path(sources, path))
        if (is_contradicted(source.check))
            largest = std::max(largest, std::abs(source.check.scale - 1.0));
    return largest;
}

ScaleSources scale_sources(const LengthData& lengths,
                           const types::Trajectory& trajectory,
                           const types::PathUncertainty& path,
                           const types::LoopStatistics& loops) {
    Collector collector;
    if (lengths.markers) collector.add("markers", lengths.markers, 0.0, "");
    if (lengths.positions) collector.add("positions", lengths.positions, 0.0, "");
    if (lengths.num_segments > 1) {
        for (const char* name : {"accelerometer", "pressure"})
            collector.leave_out(name, "the dive has several segments");
    } else {
        const auto by_accelerometer = scale_by_accelerometer(lengths.imu, trajectory);
        collector.add(
            "accelerometer",
            by_accelerometer,
            accelerometer_sigma(lengths.imu, trajectory),
            by_accelerometer ? "" : why_no_scale_by_accelerometer(lengths.imu, trajectory));
        collector.add(
            "pressure",
            scale_by_pressure(
                lengths.pressure, trajectory, covariance_scale(loops) * path.vertical_scale_sigma),
            kPressureScaleSigma,
            lengths.pressure.empty() ? "the dive has no pressure sensor, or it is not used"
                                     : "the pressure sensor covers too little of the dive");
    }
    collector.add("known_distances",
                  by_known_distances(lengths, path_error(trajectory, path)),
                  0.0,
                  "no known distance is marked in the images, and fewer than three others could be "
                  "measured");
    return collector.take();
}

}  // namespace divemesh::evaluation
