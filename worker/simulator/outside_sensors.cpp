#include "worker/simulator/outside_sensors.hpp"

#include <cmath>
#include <numbers>

#include "worker/base/angle.hpp"
#include "worker/base/hashed_random.hpp"
#include "worker/io/geographic_frame.hpp"
#include "worker/simulator/sensor_samples.hpp"

namespace divemesh::simulator {
namespace {

constexpr double kNearOutlier_m = 5.0;
constexpr double kFarOutlier_m = 40.0;
constexpr double kVelocityRate_hz = 5.0;
constexpr double kControlSigma_m = 0.02;

// The errors of a kind of positions.
struct PositionErrors {
    double rate_hz = 1.0;
    double white_m = 0.0;   // of each axis
    double slow_m = 0.0;    // the same, changing within a minute
    double offset_m = 0.0;  // the same, of the whole dive
    double outliers = 0.0;  // share of the rows
    bool has_height = true;

    double sigma_h_m() const { return std::hypot(white_m, slow_m); }
};

PositionErrors errors_of(types::PositionKind kind) {
    switch (kind) {
        case types::PositionKind::GpsFloat:
            return {.white_m = 0.3,
                    .slow_m = 1.5,
                    .offset_m = 1.4,
                    .outliers = 0.025,
                    .has_height = false};
        case types::PositionKind::Usbl: return {.rate_hz = 0.5, .white_m = 0.3, .outliers = 0.1};
        case types::PositionKind::SurfaceFix: return {.white_m = 2.0};
    }
    return {};
}

Eigen::Vector3d on_earth(const types::GeographicPosition& place, const Eigen::Vector3d& p_world) {
    Eigen::Vector3d utm_m;
    utm_m << io::utm_frame(place).A * Eigen::Vector3d(p_world.x(), p_world.y(), 1.0), p_world.z();
    return utm_m;
}

}  // namespace

types::GeographicPosition place_on_earth(std::uint64_t seed) {
    base::RandomRow random(base::hash64(seed, 0x6561727468ULL));
    return {13.19 + 0.01 * random.uniform(-1.0, 1.0),
            -59.64 + 0.01 * random.uniform(-1.0, 1.0),
            random.uniform(0.0, 360.0)};
}

types::PositionSource simulate_positions(const DiverMotion& motion,
                                         double duration_s,
                                         types::PositionKind kind,
                                         bool noise,
                                         std::uint64_t seed) {
    base::RandomRow random(base::hash64(seed, 0x706f736974ULL));
    const PositionErrors errors = errors_of(kind);
    const types::GeographicPosition place = place_on_earth(seed);
    const io::UtmFrame frame = io::utm_frame(place);
    const GaussMarkovProcess slow_x(random, 60.0);
    const GaussMarkovProcess slow_y(random, 60.0);
    const Eigen::Vector3d drawn = gaussian3(random);
    types::PositionSource source{.name = "position0", .kind = kind, .epsg = frame.epsg};
    for_each_sample(errors.rate_hz, duration_s, [&](double t_s, std::int64_t timestamp_ns) {
        if (kind == types::PositionKind::SurfaceFix && !source.samples.empty()) return;
        Eigen::Vector3d error = errors.white_m * gaussian3(random);
        error.head<2>() += errors.slow_m * Eigen::Vector2d(slow_x.at(t_s), slow_y.at(t_s)) +
                           errors.offset_m * drawn.head<2>();
        const double chance = random.uniform(0.0, 1.0);
        const double far_m = random.uniform(kNearOutlier_m, kFarOutlier_m);
        const double towards = random.uniform(0.0, 2.0 * std::numbers::pi);
        if (chance < errors.outliers)
            error.head<2>() += far_m * Eigen::Vector2d(std::cos(towards), std::sin(towards));
        if (!noise) error.setZero();
        Eigen::Vector3d p_utm_m = on_earth(place, motion.at(t_s).T_world_imu.translation() + error);
        if (!errors.has_height) p_utm_m.z() = 0.0;
        source.samples.push_back({timestamp_ns,
                                  p_utm_m,
                                  errors.sigma_h_m(),
                                  errors.has_height ? errors.sigma_h_m() : 0.0});
    });
    return source;
}

void simulate_velocities(const DiverMotion& motion,
                         double duration_s,
                         bool noise,
                         std::uint64_t seed,
                         types::OutsidePositions& outside) {
    constexpr double kSigma_m_s = 0.01;
    base::RandomRow random(base::hash64(seed, 0x64766cULL));
    outside.T_imu_dvl.linear() =
        (Eigen::AngleAxisd(std::numbers::pi, Eigen::Vector3d::UnitX()) *
         Eigen::AngleAxisd(std::numbers::pi / 4.0, Eigen::Vector3d::UnitZ()))
            .toRotationMatrix();
    outside.T_imu_dvl.translation() = Eigen::Vector3d(-0.2, 0.0, -0.1);
    const double scale = 1.0 + (noise ? 0.003 * random.gaussian() : 0.0);
    for_each_sample(kVelocityRate_hz, duration_s, [&](double t_s, std::int64_t timestamp_ns) {
        const MotionState state = motion.at(t_s);
        const Eigen::Vector3d velocity_imu =
            state.T_world_imu.linear().transpose() * state.velocity_world +
            state.angular_velocity_imu.cross(outside.T_imu_dvl.translation());
        const Eigen::Vector3d error = (noise ? kSigma_m_s : 0.0) * gaussian3(random);
        outside.velocities.push_back(
            {timestamp_ns,
             scale * (outside.T_imu_dvl.linear().transpose() * velocity_imu) + error,
             kSigma_m_s});
    });
}

void survey_markers(const std::vector<LaidMarker>& markers,
                    bool noise,
                    std::uint64_t seed,
                    types::OutsidePositions& outside) {
    base::RandomRow random(base::hash64(seed, 0x676370ULL));
    const types::GeographicPosition place = place_on_earth(seed);
    outside.control_points_epsg = io::utm_frame(place).epsg;
    for (const LaidMarker& marker : markers) {
        const Eigen::Vector3d error = (noise ? kControlSigma_m : 0.0) * gaussian3(random);
        outside.control_points.push_back({"marker " + std::to_string(marker.id),
                                          marker.id,
                                          on_earth(place, middle_world(marker) + error),
                                          kControlSigma_m,
                                          kControlSigma_m});
    }
}

}  // namespace divemesh::simulator
