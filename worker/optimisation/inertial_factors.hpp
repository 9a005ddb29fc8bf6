#pragma once

#include <Eigen/Geometry>
#include <vector>

#include "worker/imu/inertial_prior.hpp"
#include "worker/optimisation/bundle_adjustment.hpp"
#include "worker/types/keyframe.hpp"

namespace divemesh::optimisation {

// What holds an adjusted world to the real one. The first pose is held as it was first believed;
// the way down is unknown in that world, and estimated with everything else. So a better vertical
// never moves what is already known relative to the first pose.
struct WorldReference {
    Eigen::Vector3d gravity_direction_world = -Eigen::Vector3d::UnitZ();
    Eigen::Quaterniond q_world_ahrs = Eigen::Quaterniond::Identity();
    double depth_offset_m = 0.0;  // of the world's origin below the pressure sensor's surface
};

// What the sensors say about the way between two states, and about one moment.
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
// What is known before anything is measured: of the biases, where readings begin at `from`; of the
// vertical, where the pressure alone knows of it.
void add_bias_priors(BundleAdjustment& bundle_adjustment,
                     const imu::SensorReadings& readings,
                     BodyState& from);
void add_gravity_prior(BundleAdjustment& bundle_adjustment,
                       const imu::SensorReadings& readings,
                       WorldReference& reference);

// All that the inertial sensors say about the keyframes of a dive. Gives `states` first velocities;
// `reference` is estimated with them.
void add_inertial_factors(BundleAdjustment& bundle_adjustment,
                          const imu::InertialPrior& inertial,
                          const std::vector<types::Keyframe>& keyframes,
                          std::vector<BodyState>& states,
                          WorldReference& reference);

// q_level_world: the least turn that makes the adjusted world's z point up, by accelerometer and
// pressure, else by the AHRS (which also knows the heading). The identity without any.
Eigen::Quaterniond gravity_alignment(const imu::InertialPrior& inertial,
                                     const WorldReference& reference);

}  // namespace divemesh::optimisation
