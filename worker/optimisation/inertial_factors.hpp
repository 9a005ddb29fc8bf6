#pragma once

#include <Eigen/Geometry>
#include <vector>

#include "worker/imu/inertial_prior.hpp"
#include "worker/optimisation/bundle_adjustment.hpp"
#include "worker/types/keyframe.hpp"

namespace divemesh::optimisation {

// The relation of the adjusted world to the real one. The first pose is fixed, and the direction of
// gravity in that world is estimated with everything else. So a better vertical never changes what
// is known relative to the first pose.
struct WorldReference {
    Eigen::Vector3d gravity_direction_world = -Eigen::Vector3d::UnitZ();
    Eigen::Quaterniond q_world_ahrs = Eigen::Quaterniond::Identity();
    double depth_offset_m = 0.0;  // of the world's origin below the pressure sensor's surface
    double depth_scale = 1.0;     // of its depths
};

// Add the factors of the sensors between two states, and those at one time.
void add_relative_factors(BundleAdjustment& bundle_adjustment,
                          const imu::SensorReadings& readings,
                          const types::ImuNoise& noise,
                          BodyState& from,
                          BodyState& to,
                          WorldReference& reference);
void add_absolute_factors(BundleAdjustment& bundle_adjustment,
                          const imu::SensorReadings& readings,
                          BodyState& state,
                          WorldReference& reference);
// Add the priors: of the biases, as known when the readings were integrated, where these begin at
// `from`; of the vertical, if the pressure is the only sensor for it.
void add_bias_priors(BundleAdjustment& bundle_adjustment,
                     const imu::SensorReadings& readings,
                     BodyState& from);
void add_gravity_prior(BundleAdjustment& bundle_adjustment,
                       const imu::SensorReadings& readings,
                       WorldReference& reference);

// Adds all factors of the inertial sensors at the keyframes of a dive. Sets initial velocities in
// `states`; `reference` is estimated with them.
void add_inertial_factors(BundleAdjustment& bundle_adjustment,
                          const imu::InertialPrior& inertial,
                          const std::vector<types::Keyframe>& keyframes,
                          std::vector<BodyState>& states,
                          WorldReference& reference);

// Returns q_level_world: the smallest rotation that makes the adjusted world's z point up, from
// accelerometer and pressure, else from the AHRS (which also knows the heading). The identity
// without these sensors.
Eigen::Quaterniond gravity_alignment(const imu::InertialPrior& inertial,
                                     const WorldReference& reference);

}  // namespace divemesh::optimisation
