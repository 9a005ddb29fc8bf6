#pragma once

#include <Eigen/Geometry>
#include <memory>
#include <optional>
#include <vector>

#include "worker/base/observer.hpp"
#include "worker/imu/gyroscope_integral.hpp"
#include "worker/imu/preintegration.hpp"
#include "worker/optimisation/marginalisation.hpp"
#include "worker/types/rectified_rig.hpp"
#include "worker/types/solver_outcome.hpp"

namespace divemesh::optimisation {

// The body at a keyframe, as the adjustments estimate it.
struct BodyState {
    Eigen::Quaterniond q_world_imu = Eigen::Quaterniond::Identity();
    Eigen::Vector3d p_world_imu = Eigen::Vector3d::Zero();
    Eigen::Vector3d velocity_world = Eigen::Vector3d::Zero();  // m/s
    imu::ImuBias bias;

    static BodyState at(const Eigen::Isometry3d& T_world_imu, const imu::ImuBias& bias);
    Eigen::Isometry3d T_world_imu() const;
};

// How uncertain a state is against what was held, axes of the world.
struct StateCovariance {
    Eigen::Matrix3d position_m2 = Eigen::Matrix3d::Zero();
    Eigen::Matrix3d rotation_rad2 = Eigen::Matrix3d::Zero();
};

struct JointCovariance {
    std::vector<StateCovariance> states;
    Eigen::MatrixXd positions_m2;  // of all positions with each other, three rows a state
};

// Bundle adjustment: body states and landmarks that fit best what the cameras and the inertial
// sensors measured. States and landmarks belong to the caller, stay where they are until a solver
// has changed them. One thread: the same input gives the same bits.
class BundleAdjustment {
public:
    explicit BundleAdjustment(const types::RectifiedRig& rig);
    ~BundleAdjustment();
    BundleAdjustment(const BundleAdjustment&) = delete;
    BundleAdjustment& operator=(const BundleAdjustment&) = delete;

    void add_state(BodyState& state, bool fixed);
    // Those of one landmark after one another.
    void add_observation(BodyState& state,
                         Eigen::Vector3d& p_world,
                         const Eigen::Vector3d& measured_px,
                         const Eigen::Vector3d& sigma_px);
    // The gyroscope between two states; `random_walk` of its bias in rad/s^2/sqrt(Hz).
    void add_gyro_rotation(BodyState& from,
                           BodyState& to,
                           const imu::GyroscopeIntegral& rotation,
                           double random_walk);
    // Gyroscope and accelerometer between two states, and their biases, which walk as `noise` says.
    // `gravity_direction_world`, a unit vector, is where gravity points: unknown, and the same all
    // along.
    void add_imu_preintegration(BodyState& from,
                                BodyState& to,
                                const imu::PreintegratedImu& motion,
                                const types::ImuNoise& noise,
                                Eigen::Vector3d& gravity_direction_world);
    void add_gyroscope_bias(BodyState& state, const Eigen::Vector3d& known, double sigma);
    void add_accelerometer_bias(BodyState& state, const Eigen::Vector3d& known, double sigma);
    // The AHRS's word. `q_world_ahrs`, its world in ours, is unknown and the same all along.
    void add_orientation(BodyState& state,
                         Eigen::Quaterniond& q_world_ahrs,
                         const Eigen::Quaterniond& q_ahrs_imu,
                         double sigma_rad);

    // Depth below a surface that lies `offset_m` above the world's origin, unknown as well.
    void add_depth(BodyState& state,
                   Eigen::Vector3d& gravity_direction_world,
                   double& offset_m,
                   double depth_m,
                   double sigma_m);
    void add_gravity_direction(Eigen::Vector3d& gravity_direction_world,
                               const Eigen::Vector3d& known,
                               double sigma);

    void add_prior(const LinearPrior& prior);
    // What was added says this about all but the landmarks and the `leaving` blocks of numbers.
    LinearPrior marginalise(const std::vector<double*>& leaving);

    // A few states, dense.
    types::SolverOutcome solve_dense(int max_iterations);
    // Any number of states, sparse, by Ceres. Reports `at` to `progress` every iteration. Throws
    // what the callback throws.
    types::SolverOutcome solve_sparse(int max_iterations,
                                      const base::ProgressCallback& progress,
                                      const Progress& at);
    // Of states that solve_sparse has solved for, everything else marginalised; the cameras' noise
    // as their residuals show it. Nothing when the states are not determined.
    JointCovariance covariances(const std::vector<BodyState*>& states);

private:
    struct Implementation;
    std::unique_ptr<Implementation> implementation_;
};

}  // namespace divemesh::optimisation
