#include "worker/optimisation/bundle_adjustment.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/SparseCholesky>
#include <algorithm>
#include <ceres/loss_function.h>
#include <ceres/manifold.h>
#include <ceres/normal_prior.h>
#include <ceres/problem.h>
#include <ceres/solver.h>
#include <ceres/sphere_manifold.h>
#include <cmath>

#include "worker/base/rotation_vector.hpp"
#include "worker/optimisation/ceres_outcome.hpp"
#include "worker/optimisation/joint_influences.hpp"
#include "worker/optimisation/levenberg_marquardt.hpp"
#include "worker/optimisation/reduced_information.hpp"
#include "worker/optimisation/residual_field.hpp"
#include "worker/optimisation/residuals/gyro_rotation_cost.hpp"
#include "worker/optimisation/residuals/imu_preintegration_cost.hpp"
#include "worker/optimisation/residuals/orientation_prior.hpp"
#include "worker/optimisation/residuals/pressure_depth.hpp"
#include "worker/optimisation/residuals/random_walk.hpp"
#include "worker/optimisation/residuals/relative_pose.hpp"
#include "worker/optimisation/residuals/stereo_reprojection.hpp"
#include "worker/optimisation/residuals/vector_prior.hpp"
#include "worker/optimisation/solver_progress.hpp"

namespace divemesh::optimisation {
namespace {

constexpr double kHuberReprojection = 1.5;  // in sigmas
constexpr double kHuberOrientation = 2.0;
constexpr double kHuberDepth = 2.0;
constexpr double kMinWalk = 1e-6;          // rad/s, m/s^2
constexpr double kWindowTolerance = 1e-4;  // relative change of the cost
constexpr double kDiveTolerance = 1e-5;

Eigen::Index num_errors(const CalibrationUncertainty& calibration) {
    return calibration.shift_px ? calibration.covariance.rows() : 0;
}

// Returns L with L L^T the covariance.
Eigen::MatrixXd root_of(const Eigen::MatrixXd& covariance) {
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> parts(covariance);
    return parts.eigenvectors() * parts.eigenvalues().cwiseMax(0.0).cwiseSqrt().asDiagonal();
}

// Returns L with L L^T the covariance of all errors, those of the cameras first, then the residual
// field's, the clock's and the gyroscope's.
Eigen::MatrixXd root_of(const CalibrationUncertainty& calibration,
                        double field_sigma_px,
                        const SharedJacobian& jacobian) {
    const Eigen::Index num = num_errors(calibration);
    const Eigen::Index num_cameras = num + kFieldSize;
    const Eigen::Index size = num_cameras + jacobian.num_sensor_columns();
    Eigen::MatrixXd root = Eigen::MatrixXd::Zero(size, size);
    if (num > 0) root.topLeftCorner(num, num) = root_of(calibration.covariance);
    root.diagonal().segment<kFieldSize>(num).setConstant(field_sigma_px);
    if (jacobian.by_time.size() > 0)
        root(num_cameras, num_cameras) = calibration.time_offset_sigma_s;
    if (!jacobian.of_rates.empty())
        root.bottomRightCorner<3, 3>() = root_of(calibration.rate_error_covariance);
    return root;
}

// Records the positions before and after the last step that the solver took.
class PositionRecorder : public ceres::IterationCallback {
public:
    explicit PositionRecorder(const std::vector<BodyState*>& states) : states_(states) {}

    ceres::CallbackReturnType operator()(const ceres::IterationSummary& iteration) override {
        if (iteration.iteration > 0 && !iteration.step_is_successful) return ceres::SOLVER_CONTINUE;
        before_m_ = std::move(after_m_);
        after_m_.clear();
        for (const BodyState* state : states_) after_m_.push_back(state->p_world_imu);
        return ceres::SOLVER_CONTINUE;
    }

    std::vector<Eigen::Vector3d> last_moves_m() const {
        std::vector<Eigen::Vector3d> moves_m(states_.size(), Eigen::Vector3d::Zero());
        for (std::size_t i = 0; i < before_m_.size(); ++i) moves_m[i] = after_m_[i] - before_m_[i];
        return moves_m;
    }

private:
    const std::vector<BodyState*>& states_;
    std::vector<Eigen::Vector3d> before_m_;
    std::vector<Eigen::Vector3d> after_m_;
};

}  // namespace

BodyState BodyState::at(const Eigen::Isometry3d& T_world_imu, const imu::ImuBias& bias) {
    return {Eigen::Quaterniond(T_world_imu.linear()).normalized(),
            T_world_imu.translation(),
            Eigen::Vector3d::Zero(),
            bias};
}

Eigen::Isometry3d BodyState::T_world_imu() const {
    Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
    T.linear() = q_world_imu.normalized().toRotationMatrix();
    T.translation() = p_world_imu;
    return T;
}

struct BundleAdjustment::Implementation {
    explicit Implementation(const types::RectifiedRig& rectified) : rig(rectified) {}

    double* q(BodyState& state) { return state.q_world_imu.coeffs().data(); }
    void add(ceres::CostFunction* cost,
             ceres::LossFunction* loss,
             const std::vector<double*>& blocks) {
        graph.add_factor(std::unique_ptr<ceres::CostFunction>(cost), loss, blocks);
    }
    void add_walk(double* from, double* to, double density, double duration_s) {
        const double sigma = std::max(kMinWalk, density * std::sqrt(duration_s));
        add(RandomWalk::create(sigma), nullptr, {from, to});
    }
    void add_vector(Eigen::Vector3d& vector, const Eigen::Vector3d& known, double sigma) {
        add(VectorPrior::create({known, sigma}), nullptr, {vector.data()});
    }

    // Notes that the factor which was added last contains the integral and depends on the bias.
    void note_gyro_factor(const imu::GyroscopeIntegral& integral, const double* bias) {
        gyro_factors.push_back(
            {graph.factors().size() - 1,
             bias,
             base::vector_from_rotation(integral.q_from_to) / integral.duration_s});
    }

    // Returns the first column of each block in the information (-1: held constant), and at the end
    // the number of columns.
    std::vector<int> block_columns() const;
    SharedJacobian shared_jacobian(const CalibrationUncertainty& calibration,
                                   const std::vector<BodyRates>& rates) const;
    void add_clock(const std::vector<BodyRates>& rates, SharedJacobian& shared) const;
    void add_rate_errors(SharedJacobian& shared) const;

    // A factor of the gyroscope.
    struct GyroFactor {
        std::size_t factor = 0;  // its number in the graph
        const double* bias = nullptr;
        Eigen::Vector3d rate = Eigen::Vector3d::Zero();  // mean over the motion, rad/s, imu
    };

    types::RectifiedRig rig;
    std::vector<BodyState*> states;
    ceres::EigenQuaternionManifold rotation;
    ceres::SphereManifold<3> direction;
    ceres::HuberLoss orientation_loss{kHuberOrientation};
    ceres::HuberLoss depth_loss{kHuberDepth};
    FactorGraph graph{kHuberReprojection};
    std::vector<GyroFactor> gyro_factors;
    std::unique_ptr<ceres::Problem> problem;  // of solve_sparse
    std::vector<Eigen::Vector3d> last_moves_m;
};

SharedJacobian BundleAdjustment::Implementation::shared_jacobian(
    const CalibrationUncertainty& calibration, const std::vector<BodyRates>& rates) const {
    SharedJacobian shared;
    const Eigen::Index num = num_errors(calibration);
    shared.num_columns = static_cast<int>(num) + kFieldSize;
    shared.of_observation = [&, num](std::size_t observation) -> Eigen::Matrix3Xd {
        const StereoReprojection& seen = graph.observations()[observation].reprojection;
        Eigen::Matrix3Xd shift(3, num + kFieldSize);
        if (num > 0) shift.leftCols(num) = calibration.shift_px(seen.measured_px);
        shift.rightCols<kFieldSize>() = by_field(rig, seen.measured_px);
        return seen.sigma_px.cwiseInverse().asDiagonal() * shift;
    };
    if (calibration.time_offset_sigma_s > 0.0 && rates.size() == states.size())
        add_clock(rates, shared);
    if (!calibration.rate_error_covariance.isZero(0.0)) add_rate_errors(shared);
    return shared;
}

std::vector<int> BundleAdjustment::Implementation::block_columns() const {
    std::vector<int> columns;
    int size = 0;
    for (const Block& block : graph.blocks()) {
        columns.push_back(block.fixed ? -1 : size);
        if (!block.fixed) size += block.tangent_size();
    }
    columns.push_back(size);
    return columns;
}

void BundleAdjustment::Implementation::add_clock(const std::vector<BodyRates>& rates,
                                                 SharedJacobian& shared) const {
    const std::vector<int> columns = block_columns();
    shared.by_time = Eigen::VectorXd::Zero(columns.back());
    const auto moves = [&](double* block, const Eigen::Vector3d& per_second) {
        if (!graph.contains(block)) return;
        const int at = columns[static_cast<std::size_t>(graph.index_of(block))];
        if (at >= 0)
            shared.by_time.segment<3>(at) = per_second;
        else
            shared.constants.push_back({block, per_second});
    };
    for (std::size_t k = 0; k < states.size(); ++k) {
        BodyState& state = *states[k];
        // Ceres' tangent of a quaternion is half the rotation vector.
        moves(state.q_world_imu.coeffs().data(), 0.5 * rates[k].angular_velocity_world);
        moves(state.p_world_imu.data(), state.velocity_world);
        moves(state.velocity_world.data(), rates[k].acceleration_world);
    }
}

void BundleAdjustment::Implementation::add_rate_errors(SharedJacobian& shared) const {
    const std::vector<int> columns = block_columns();
    std::vector<int> first_rows;
    int num_rows = 0;
    for (const Factor& factor : graph.factors()) {
        first_rows.push_back(num_rows);
        num_rows += factor.cost->num_residuals();
    }
    for (const GyroFactor& of : gyro_factors)
        shared.of_rates.push_back({first_rows[of.factor],
                                   graph.factors()[of.factor].cost->num_residuals(),
                                   columns[static_cast<std::size_t>(graph.index_of(of.bias))],
                                   of.rate});
}

BundleAdjustment::BundleAdjustment(const types::RectifiedRig& rig)
    : implementation_(std::make_unique<Implementation>(rig)) {}
BundleAdjustment::~BundleAdjustment() = default;

void BundleAdjustment::add_state(BodyState& state, bool fixed) {
    auto& own = *implementation_;
    own.states.push_back(&state);
    own.graph.add_block(own.q(state), 4, &own.rotation);
    own.graph.add_block(state.p_world_imu.data(), 3);
    if (!fixed) return;
    own.graph.fix(own.q(state));
    own.graph.fix(state.p_world_imu.data());
}

void BundleAdjustment::add_observation(BodyState& state,
                                       Eigen::Vector3d& p_world,
                                       const Eigen::Vector3d& measured_px,
                                       const Eigen::Vector3d& sigma_px) {
    auto& own = *implementation_;
    own.graph.add_observation(
        {own.rig, measured_px, sigma_px}, own.q(state), state.p_world_imu.data(), p_world);
}

void BundleAdjustment::add_gyro_rotation(BodyState& from,
                                         BodyState& to,
                                         const imu::GyroscopeIntegral& rotation,
                                         double random_walk) {
    auto& own = *implementation_;
    double* bias = from.bias.gyroscope.data();
    own.add(GyroRotationCost::create(rotation), nullptr, {own.q(from), own.q(to), bias});
    own.note_gyro_factor(rotation, bias);
    own.add_walk(bias, to.bias.gyroscope.data(), random_walk, rotation.duration_s);
}

void BundleAdjustment::add_imu_preintegration(BodyState& from,
                                              BodyState& to,
                                              const imu::PreintegratedImu& motion,
                                              const types::ImuNoise& noise,
                                              Eigen::Vector3d& gravity_direction_world) {
    auto& own = *implementation_;
    double* gyroscope = from.bias.gyroscope.data();
    double* accelerometer = from.bias.accelerometer.data();
    own.graph.add_block(gravity_direction_world.data(), 3, &own.direction);
    own.add(ImuPreintegrationCost::create(motion),
            nullptr,
            {own.q(from),
             from.p_world_imu.data(),
             from.velocity_world.data(),
             gyroscope,
             accelerometer,
             own.q(to),
             to.p_world_imu.data(),
             to.velocity_world.data(),
             gravity_direction_world.data()});
    own.note_gyro_factor(motion.rotation, gyroscope);
    const double duration_s = motion.rotation.duration_s;
    own.add_walk(gyroscope, to.bias.gyroscope.data(), noise.gyroscope_random_walk, duration_s);
    own.add_walk(
        accelerometer, to.bias.accelerometer.data(), noise.accelerometer_random_walk, duration_s);
}

void BundleAdjustment::add_motion(BodyState& from,
                                  BodyState& to,
                                  const Eigen::Isometry3d& T_from_to,
                                  double sigma_m,
                                  double sigma_rad) {
    auto& own = *implementation_;
    own.add(RelativePose::create(T_from_to, sigma_m, sigma_rad),
            nullptr,
            {own.q(from), from.p_world_imu.data(), own.q(to), to.p_world_imu.data()});
}

void BundleAdjustment::add_velocity(BodyState& state, const Eigen::Vector3d& known, double sigma) {
    implementation_->add_vector(state.velocity_world, known, sigma);
}

void BundleAdjustment::add_gyroscope_bias(BodyState& state,
                                          const Eigen::Vector3d& known,
                                          double sigma) {
    implementation_->add_vector(state.bias.gyroscope, known, sigma);
}

void BundleAdjustment::add_accelerometer_bias(BodyState& state,
                                              const Eigen::Vector3d& known,
                                              double sigma) {
    implementation_->add_vector(state.bias.accelerometer, known, sigma);
}

void BundleAdjustment::add_orientation(BodyState& state,
                                       Eigen::Quaterniond& q_world_ahrs,
                                       const Eigen::Quaterniond& q_ahrs_imu,
                                       double sigma_rad) {
    auto& own = *implementation_;
    double* alignment = q_world_ahrs.coeffs().data();
    own.graph.add_block(alignment, 4, &own.rotation);
    own.add(OrientationPrior::create({q_ahrs_imu, sigma_rad}),
            &own.orientation_loss,
            {alignment, own.q(state)});
}

void BundleAdjustment::add_depth(BodyState& state,
                                 Eigen::Vector3d& gravity_direction_world,
                                 double& offset_m,
                                 double& scale,
                                 double depth_m,
                                 double sigma_m) {
    auto& own = *implementation_;
    own.graph.add_block(gravity_direction_world.data(), 3, &own.direction);
    own.add(PressureDepth::create({depth_m, sigma_m}),
            &own.depth_loss,
            {state.p_world_imu.data(), gravity_direction_world.data(), &offset_m, &scale});
}

void BundleAdjustment::add_depth_scale(double& scale, double sigma) {
    auto& own = *implementation_;
    if (!own.graph.contains(&scale)) return;
    if (sigma > 0.0)
        own.add(new ceres::NormalPrior(Eigen::MatrixXd::Constant(1, 1, 1.0 / sigma),
                                       Eigen::VectorXd::Ones(1)),
                nullptr,
                {&scale});
    else
        own.graph.fix(&scale);
}

void BundleAdjustment::add_gravity_direction(Eigen::Vector3d& gravity_direction_world,
                                             const Eigen::Vector3d& known,
                                             double sigma) {
    auto& own = *implementation_;
    own.graph.add_block(gravity_direction_world.data(), 3, &own.direction);
    own.add_vector(gravity_direction_world, known, sigma);
}

void BundleAdjustment::add_prior(const LinearPrior& prior) {
    auto& own = *implementation_;
    for (const auto& block : prior.blocks) {
        const auto size = static_cast<int>(block.at.size());
        ceres::Manifold* manifold = nullptr;
        if (size == 4) manifold = &own.rotation;
        if (size == 3 && block.tangent_size == 2) manifold = &own.direction;
        own.graph.add_block(block.values, size, manifold);
    }
    optimisation::add_prior(own.graph, prior);
}

LinearPrior BundleAdjustment::marginalise(const std::vector<double*>& leaving) {
    return optimisation::marginalise(implementation_->graph, leaving);
}

types::SolverOutcome BundleAdjustment::solve_dense(int max_iterations) {
    return levenberg_marquardt(implementation_->graph, max_iterations, kWindowTolerance);
}

types::SolverOutcome BundleAdjustment::solve_sparse(int max_iterations,
                                                    const base::ProgressCallback& progress,
                                                    const Progress& at) {
    auto& own = *implementation_;
    own.graph.drop_unseen();
    own.problem = own.graph.problem();
    ceres::Solver::Options options;
    options.linear_solver_type = ceres::SPARSE_SCHUR;
    options.linear_solver_ordering = std::make_shared<ceres::ParameterBlockOrdering>();
    for (Eigen::Vector3d* landmark : own.graph.landmarks())
        if (own.problem->HasParameterBlock(landmark->data()))
            options.linear_solver_ordering->AddElementToGroup(landmark->data(), 0);
    for (const Block& block : own.graph.blocks())
        options.linear_solver_ordering->AddElementToGroup(block.values, 1);
    options.max_num_iterations = max_iterations;
    options.function_tolerance = kDiveTolerance;
    options.logging_type = ceres::SILENT;
    options.num_threads = 1;
    SolverProgress callback(progress, at);
    PositionRecorder positions(own.states);
    options.callbacks = {&callback, &positions};
    options.update_state_every_iteration = true;
    ceres::Solver::Summary summary;
    ceres::Solve(options, own.problem.get(), &summary);
    callback.rethrow();
    own.last_moves_m = positions.last_moves_m();
    return outcome_of(summary);
}

const std::vector<Eigen::Vector3d>& BundleAdjustment::last_moves_m() const {
    return implementation_->last_moves_m;
}

namespace {

std::vector<double*> values_of(const std::vector<Block>& blocks) {
    std::vector<double*> values;
    for (const Block& block : blocks) values.push_back(block.values);
    return values;
}

std::vector<double*> points_in(const ceres::Problem& problem,
                               const std::vector<Eigen::Vector3d*>& landmarks) {
    std::vector<double*> points;
    for (Eigen::Vector3d* landmark : landmarks)
        if (problem.HasParameterBlock(landmark->data())) points.push_back(landmark->data());
    return points;
}

Eigen::MatrixXd beside(const Eigen::MatrixXd& left, const Eigen::MatrixXd& right) {
    Eigen::MatrixXd both(left.rows(), left.cols() + right.cols());
    both << left, right;
    return both;
}

}  // namespace

JointCovariance BundleAdjustment::covariances(const std::vector<BodyState*>& states,
                                              const CalibrationUncertainty& calibration,
                                              const std::vector<BodyRates>& rates,
                                              JointOf joint_of) {
    auto& own = *implementation_;
    const SharedJacobian jacobian = own.shared_jacobian(calibration, rates);
    const ClusteredInformation information =
        clustered_information(*own.problem,
                              values_of(own.graph.blocks()),
                              points_in(*own.problem, own.graph.landmarks()),
                              kHuberReprojection,
                              jacobian);
    const Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> factor(information.H_lower);
    if (factor.info() != Eigen::Success || factor.vectorD().minCoeff() <= 0.0) return {};
    const auto V = information.V_lower.selfadjointView<Eigen::Lower>();
    const auto start_of = [&](const double* block) {
        return information.start[static_cast<std::size_t>(own.graph.index_of(block))];
    };
    const auto influence = [&](const double* block) -> Eigen::MatrixXd {
        Eigen::MatrixXd unit = Eigen::MatrixXd::Zero(information.H_lower.rows(), 3);
        if (start_of(block) < 0) return unit;
        unit.middleRows<3>(start_of(block)).setIdentity();
        return factor.solve(unit);
    };
    const Eigen::MatrixXd moved_by_errors = factor.solve(information.B);
    const double field_sigma_px =
        std::sqrt(field_variance(information, moved_by_errors, num_errors(calibration)));
    // One column per independent error of the calibration.
    const Eigen::MatrixXd by_calibration =
        moved_by_errors * root_of(calibration, field_sigma_px, jacobian);
    const auto shared = [&](const double* block) -> Eigen::MatrixXd {
        if (start_of(block) < 0) return Eigen::MatrixXd::Zero(3, by_calibration.cols());
        return by_calibration.middleRows<3>(start_of(block));
    };
    JointCovariance result;
    const auto num_states = std::ssize(states);
    JointInfluences positions(3, num_states, factor.rows(), by_calibration.cols());
    JointInfluences poses(
        6, joint_of == JointOf::Poses ? num_states : 0, factor.rows(), by_calibration.cols());
    for (BodyState* const state : states) {
        const Eigen::MatrixXd position = influence(state->p_world_imu.data());
        const Eigen::MatrixXd varied = V * position;
        const Eigen::MatrixXd moved = shared(state->p_world_imu.data());
        positions.add(position, varied, moved);
        // Ceres' tangent of a quaternion is half the rotation vector.
        const Eigen::MatrixXd rotation = 2.0 * influence(own.q(*state));
        const Eigen::MatrixXd turned = 2.0 * shared(own.q(*state));
        const Eigen::MatrixXd varied_rotation = V * rotation;
        result.states.push_back(
            {position.transpose() * varied + moved * moved.transpose(),
             rotation.transpose() * varied_rotation + turned * turned.transpose()});
        if (joint_of == JointOf::Poses)
            poses.add(beside(position, rotation),
                      beside(varied, varied_rotation),
                      beside(moved.transpose(), turned.transpose()).transpose());
    }
    result.positions_m2 = std::move(positions.covariance());
    result.by_calibration_m = std::move(positions.by_calibration());
    if (joint_of == JointOf::Poses) {
        result.poses = std::move(poses.covariance());
        result.poses_by_calibration = std::move(poses.by_calibration());
    }
    return result;
}

}  // namespace divemesh::optimisation
