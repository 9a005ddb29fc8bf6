#include "worker/optimisation/inertial_factors.hpp"

#include <algorithm>
#include <cmath>

#include "worker/base/seconds.hpp"

namespace divemesh::optimisation {
namespace {

// The AHRS has a slow error of half a degree: neighbours in time repeat the same error. A
// Gauss-Markov error is represented by white noise whose variance is multiplied by twice its time
// constant over the interval.
constexpr double kAhrsSigma_rad = 0.01;
constexpr double kAhrsTimeConstant_s = 30.0;
// Recorders turn pressure into depth with the density that they are set to: fresh and sea water
// differ by 2.5 to 3 %.
constexpr double kPressureScaleSigma = 0.025;
constexpr double kInitialGravitySigma = 0.2;  // of the vertical, where hardly anything tells it

// Sets velocities by central differences of the positions.
void set_velocities(const std::vector<types::Keyframe>& keyframes, std::vector<BodyState>& states) {
    for (std::size_t k = 0; k < states.size(); ++k) {
        const std::size_t before = k > 0 ? k - 1 : k;
        const std::size_t after = std::min(k + 1, states.size() - 1);
        if (before == after) continue;
        states[k].velocity_world =
            (states[after].p_world_imu - states[before].p_world_imu) /
            base::to_s(keyframes[after].timestamp_ns - keyframes[before].timestamp_ns);
    }
}

const imu::GyroscopeIntegral* rotation_of(const imu::SensorReadings& readings) {
    if (readings.motion) return &readings.motion->rotation;
    return readings.rotation ? &*readings.rotation : nullptr;
}

}  // namespace

void add_relative_factors(BundleAdjustment& bundle_adjustment,
                          const imu::SensorReadings& readings,
                          const types::ImuNoise& noise,
                          BodyState& from,
                          BodyState& to,
                          WorldReference& reference) {
    if (readings.motion)
        bundle_adjustment.add_imu_preintegration(
            from, to, *readings.motion, noise, reference.gravity_direction_world);
    if (readings.rotation)
        bundle_adjustment.add_gyro_rotation(
            from, to, *readings.rotation, noise.gyroscope_random_walk);
}

void add_absolute_factors(BundleAdjustment& bundle_adjustment,
                          const imu::SensorReadings& readings,
                          BodyState& state,
                          WorldReference& reference) {
    if (readings.q_ahrs_imu) {
        const double times = 2.0 * kAhrsTimeConstant_s / std::max(0.1, readings.interval_s);
        bundle_adjustment.add_orientation(state,
                                          reference.q_world_ahrs,
                                          *readings.q_ahrs_imu,
                                          kAhrsSigma_rad * std::sqrt(std::max(1.0, times)));
    }
    if (readings.depth_m)
        bundle_adjustment.add_depth(state,
                                    reference.gravity_direction_world,
                                    reference.depth_offset_m,
                                    reference.depth_scale,
                                    *readings.depth_m,
                                    readings.depth_sigma_m);
}

void add_bias_priors(BundleAdjustment& bundle_adjustment,
                     const imu::SensorReadings& readings,
                     BodyState& from) {
    if (const auto* rotation = rotation_of(readings))
        bundle_adjustment.add_gyroscope_bias(from, rotation->bias, imu::kInitialGyroscopeBiasSigma);
    if (readings.motion)
        bundle_adjustment.add_accelerometer_bias(
            from, readings.motion->accelerometer_bias, imu::kInitialAccelerometerBiasSigma);
}

void add_gravity_prior(BundleAdjustment& bundle_adjustment,
                       const imu::SensorReadings& readings,
                       WorldReference& reference) {
    if (readings.depth_m && !readings.motion)
        bundle_adjustment.add_gravity_direction(reference.gravity_direction_world,
                                                reference.gravity_direction_world,
                                                kInitialGravitySigma);
}

void add_inertial_factors(BundleAdjustment& bundle_adjustment,
                          const imu::InertialPrior& inertial,
                          const std::vector<types::Keyframe>& keyframes,
                          std::vector<BodyState>& states,
                          WorldReference& reference) {
    set_velocities(keyframes, states);
    bool chained = false;  // true if readings from the previous keyframe exist
    bool moved = false;    // true if a motion from the previous keyframe exists
    bool has_motion = false;
    // The velocities before and after a single motion explain any direction of gravity.
    bool knows_gravity = false;
    for (std::size_t k = 0; k < states.size(); ++k) {
        const std::int64_t now_ns = keyframes[k].timestamp_ns;
        const imu::SensorReadings readings =
            inertial.readings(k > 0 ? keyframes[k - 1].timestamp_ns : now_ns, now_ns);
        add_absolute_factors(bundle_adjustment, readings, states[k], reference);
        if (k == 0) {
            reference.depth_offset_m = readings.depth_m.value_or(0.0);
            continue;
        }
        if (k == 1) add_gravity_prior(bundle_adjustment, readings, reference);
        if (!chained) add_bias_priors(bundle_adjustment, readings, states[k - 1]);
        add_relative_factors(
            bundle_adjustment, readings, inertial.noise(), states[k - 1], states[k], reference);
        chained = readings.motion || readings.rotation;
        knows_gravity = knows_gravity || (moved && readings.motion);
        moved = readings.motion.has_value();
        has_motion = has_motion || moved;
    }
    if (has_motion && !knows_gravity)
        bundle_adjustment.add_gravity_direction(reference.gravity_direction_world,
                                                reference.gravity_direction_world,
                                                kInitialGravitySigma);
    bundle_adjustment.add_depth_scale(reference.depth_scale, kPressureScaleSigma);
}

Eigen::Quaterniond gravity_alignment(const imu::InertialPrior& inertial,
                                     const WorldReference& reference) {
    if (inertial.has_accelerometer() || inertial.has_pressure())
        return Eigen::Quaterniond::FromTwoVectors(reference.gravity_direction_world,
                                                  -Eigen::Vector3d::UnitZ());
    return reference.q_world_ahrs.conjugate();
}

}  // namespace divemesh::optimisation
