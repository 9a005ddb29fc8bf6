#pragma once

#include <Eigen/Geometry>
#include <functional>
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

// The state of the body at a keyframe.
struct BodyState {
    Eigen::Quaterniond q_world_imu = Eigen::Quaterniond::Identity();
    Eigen::Vector3d p_world_imu = Eigen::Vector3d::Zero();
    Eigen::Vector3d velocity_world = Eigen::Vector3d::Zero();  // m/s
    imu::ImuBias bias;

    static BodyState at(const Eigen::Isometry3d& T_world_imu, const imu::ImuBias& bias);
    Eigen::Isometry3d T_world_imu() const;
};

// The covariance of a state relative to what was held constant, in the axes of the world.
struct StateCovariance {
    Eigen::Matrix3d position_m2 = Eigen::Matrix3d::Zero();
    Eigen::Matrix3d rotation_rad2 = Eigen::Matrix3d::Zero();
};

// The covariances of several states.
struct JointCovariance {
    std::vector<StateCovariance> states;  // with the errors of the calibration
    // Both have three rows per state, for its position: the joint covariance by what was measured,
    // and what each independent error of the calibration adds, one standard deviation per column.
    Eigen::MatrixXd positions_m2;
    Eigen::MatrixXd by_calibration_m;
    // The same for whole poses, six rows per state: position, m, then rotation vector, rad, both in
    // the axes of the world. Empty unless asked for.
    Eigen::MatrixXd poses;
    Eigen::MatrixXd poses_by_calibration;
};

// How uncertain the calibration is. It is not estimated with the states, but its errors are
// shared by all measurements, so they belong to the covariance (Schmidt's consider parameters).
struct CalibrationUncertainty {
    // Returns d(u, v, disparity)/d(error), a column per error of the cameras: what must be added to
    // a predicted measurement for it to be the measured one. Empty: the calibration is exact.
    std::function<Eigen::Matrix3Xd(const Eigen::Vector3d& measured_px)> shift_px;
    Eigen::MatrixXd covariance;        // of these errors
    double time_offset_sigma_s = 0.0;  // of the clocks of the cameras and of the IMU
    // Covariance of the shares by which the gyroscope's rates are too large, axes of the IMU.
    Eigen::Matrix3d rate_error_covariance = Eigen::Matrix3d::Zero();
};

// How a state changes with time.
struct BodyRates {
    Eigen::Vector3d angular_velocity_world = Eigen::Vector3d::Zero();  // rad/s
    Eigen::Vector3d acceleration_world = Eigen::Vector3d::Zero();      // m/s^2
};

// Whether a joint covariance is wanted of positions alone or of whole poses too.
enum class JointOf { Positions, Poses };

// Bundle adjustment: estimates body states and landmarks from what the cameras and the inertial
// sensors measured. The caller owns states and landmarks and must not move them in memory; solvers
// change them in place. Single-threaded: the same input gives the same bits.
class BundleAdjustment {
public:
    explicit BundleAdjustment(const types::RectifiedRig& rig);
    ~BundleAdjustment();
    BundleAdjustment(const BundleAdjustment&) = delete;
    BundleAdjustment& operator=(const BundleAdjustment&) = delete;

    void add_state(BodyState& state, bool fixed);
    // Adds an observation of a landmark; those of one landmark must follow each other.
    void add_observation(BodyState& state,
                         Eigen::Vector3d& p_world,
                         const Eigen::Vector3d& measured_px,
                         const Eigen::Vector3d& sigma_px);
    // Adds the gyroscope's rotation between two states; `random_walk` of its bias in
    // rad/s^2/sqrt(Hz).
    void add_gyro_rotation(BodyState& from,
                           BodyState& to,
                           const imu::GyroscopeIntegral& rotation,
                           double random_walk);
    // Adds gyroscope and accelerometer between two states, and the random walk of their biases by
    // `noise`. `gravity_direction_world`, a unit vector along gravity, is unknown and constant.
    void add_imu_preintegration(BodyState& from,
                                BodyState& to,
                                const imu::PreintegratedImu& motion,
                                const types::ImuNoise& noise,
                                Eigen::Vector3d& gravity_direction_world);
    // Adds a known motion between two states, with its standard deviations.
    void add_motion(BodyState& from,
                    BodyState& to,
                    const Eigen::Isometry3d& T_from_to,
                    double sigma_m,
                    double sigma_rad);
    void add_velocity(BodyState& state, const Eigen::Vector3d& known, double sigma);
    void add_gyroscope_bias(BodyState& state, const Eigen::Vector3d& known, double sigma);
    void add_accelerometer_bias(BodyState& state, const Eigen::Vector3d& known, double sigma);
    // Adds an orientation from the AHRS. `q_world_ahrs`, the AHRS's world in ours, is unknown and
    // constant.
    void add_orientation(BodyState& state,
                         Eigen::Quaterniond& q_world_ahrs,
                         const Eigen::Quaterniond& q_ahrs_imu,
                         double sigma_rad);

    // Adds a depth below a surface that lies `offset_m` above the world's origin; the offset and
    // the scale of the sensor's depths are unknown too.
    void add_depth(BodyState& state,
                   Eigen::Vector3d& gravity_direction_world,
                   double& offset_m,
                   double& scale,
                   double depth_m,
                   double sigma_m);
    // Adds what is known of the scale of depths that were added before; sigma 0: it is 1.
    void add_depth_scale(double& scale, double sigma);
    void add_gravity_direction(Eigen::Vector3d& gravity_direction_world,
                               const Eigen::Vector3d& known,
                               double sigma);

    void add_prior(const LinearPrior& prior);
    // Returns the prior that all added factors give for the remaining blocks: landmarks and the
    // `leaving` blocks are marginalised.
    LinearPrior marginalise(const std::vector<double*>& leaving);

    // Solves for a few states with dense matrices. Returns how the solver ended.
    types::SolverOutcome solve_dense(int max_iterations);
    // Solves for any number of states with Ceres' sparse solver. Reports `at` to `progress` in
    // every iteration and rethrows what the callback throws. Returns how the solver ended.
    types::SolverOutcome solve_sparse(int max_iterations,
                                      const base::ProgressCallback& progress,
                                      const Progress& at);
    // Returns how the last step of solve_sparse moved the positions, m, in the order in which the
    // states were added.
    const std::vector<Eigen::Vector3d>& last_moves_m() const;
    // Returns the joint covariance of states after solve_sparse, with everything else marginalised,
    // the cameras' noise as in their residuals, and the errors of the calibration. `rates` are
    // those of the states, in the order in which they were added. `states` is empty if they are not
    // determined.
    JointCovariance covariances(const std::vector<BodyState*>& states,
                                const CalibrationUncertainty& calibration = {},
                                const std::vector<BodyRates>& rates = {},
                                JointOf joint_of = JointOf::Positions);

private:
    struct Implementation;
    std::unique_ptr<Implementation> implementation_;
};

}  // namespace divemesh::optimisation
