#include "worker/estimation/adjustment.hpp"

#include <algorithm>
#include <ceres/loss_function.h>
#include <ceres/manifold.h>
#include <ceres/problem.h>
#include <ceres/solver.h>
#include <ceres/sphere_manifold.h>
#include <cmath>
#include <initializer_list>
#include <unordered_map>
#include <unordered_set>

#include "worker/estimation/reduced_information.hpp"
#include "worker/estimation/solver_progress.hpp"
#include "worker/estimation/sparse_inverse.hpp"
#include "worker/residuals/gyroscope_turn.hpp"
#include "worker/residuals/inertial_motion.hpp"
#include "worker/residuals/known_orientation.hpp"
#include "worker/residuals/pressure_depth.hpp"
#include "worker/residuals/random_walk.hpp"
#include "worker/residuals/stereo_reprojection.hpp"
#include "worker/residuals/vector_prior.hpp"

namespace divemesh::worker {
namespace {

constexpr double kHuberReprojection = 1.5;  // in sigmas
constexpr double kHuberOrientation = 2.0;
constexpr double kHuberDepth = 2.0;
constexpr double kLeastWalk = 1e-6;  // rad/s, m/s^2

ceres::Problem::Options problem_options() {
    ceres::Problem::Options options;
    options.manifold_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
    options.loss_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
    return options;
}

}  // namespace

BodyState BodyState::at(const Eigen::Isometry3d& T_world_imu, const ImuBias& bias) {
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

struct Adjustment::Implementation {
    explicit Implementation(const RectifiedRig& rectified) : rig(rectified) {}

    double* q(BodyState& state) { return state.q_world_imu.coeffs().data(); }
    // All but the landmarks, in the order of their first use.
    void order(std::initializer_list<double*> blocks) {
        for (double* block : blocks)
            if (ordered.insert(block).second) others.push_back(block);
    }
    // Landmarks go first. In a group the solver goes by addresses, which tell nothing about blocks
    // of different allocations: a window's other blocks, where no better order is sought, are given
    // one group each.
    std::shared_ptr<ceres::ParameterBlockOrdering> elimination_order(Size size) const {
        auto ordering = std::make_shared<ceres::ParameterBlockOrdering>();
        for (double* landmark : landmarks) ordering->AddElementToGroup(landmark, 0);
        int group = 1;
        for (double* block : others) {
            ordering->AddElementToGroup(block, group);
            if (size == Size::Window) ++group;
        }
        return ordering;
    }
    void add_walk(double* from, double* to, double density, double duration_s) {
        const double sigma = std::max(kLeastWalk, density * std::sqrt(duration_s));
        problem.AddResidualBlock(RandomWalk::create(sigma), nullptr, from, to);
        order({from, to});
    }
    void add_vector(Eigen::Vector3d& vector, const Eigen::Vector3d& known, double sigma) {
        problem.AddResidualBlock(VectorPrior::create({known, sigma}), nullptr, vector.data());
        order({vector.data()});
    }

    RectifiedRig rig;
    ceres::EigenQuaternionManifold rotation;
    ceres::SphereManifold<3> direction;
    ceres::HuberLoss reprojection_loss{kHuberReprojection};
    ceres::HuberLoss orientation_loss{kHuberOrientation};
    ceres::HuberLoss depth_loss{kHuberDepth};
    std::vector<double*> landmarks;
    std::vector<double*> others;
    std::unordered_set<double*> ordered;  // the others, to know them again
    ceres::Problem problem{problem_options()};
};

Adjustment::Adjustment(const RectifiedRig& rig)
    : implementation_(std::make_unique<Implementation>(rig)) {}
Adjustment::~Adjustment() = default;

void Adjustment::add_state(BodyState& state, bool fixed) {
    auto& own = *implementation_;
    own.problem.AddParameterBlock(own.q(state), 4, &own.rotation);
    own.problem.AddParameterBlock(state.p_world_imu.data(), 3);
    own.order({own.q(state), state.p_world_imu.data()});
    if (!fixed) return;
    own.problem.SetParameterBlockConstant(own.q(state));
    own.problem.SetParameterBlockConstant(state.p_world_imu.data());
}

void Adjustment::add_observation(BodyState& state,
                                 Eigen::Vector3d& p_world,
                                 const Eigen::Vector3d& measured_px,
                                 const Eigen::Vector3d& sigma_px) {
    auto& own = *implementation_;
    own.problem.AddResidualBlock(StereoReprojection::create({own.rig, measured_px, sigma_px}),
                                 &own.reprojection_loss,
                                 own.q(state),
                                 state.p_world_imu.data(),
                                 p_world.data());
    own.landmarks.push_back(p_world.data());
}

void Adjustment::add_turn(BodyState& from,
                          BodyState& to,
                          const GyroscopeIntegral& turn,
                          double random_walk) {
    auto& own = *implementation_;
    double* bias = from.bias.gyroscope.data();
    own.problem.AddResidualBlock(
        GyroscopeTurn::create(turn), nullptr, own.q(from), own.q(to), bias);
    own.add_walk(bias, to.bias.gyroscope.data(), random_walk, turn.duration_s);
}

void Adjustment::add_motion(BodyState& from,
                            BodyState& to,
                            const PreintegratedImu& motion,
                            const ImuNoise& noise,
                            Eigen::Vector3d& down_world) {
    auto& own = *implementation_;
    double* gyroscope = from.bias.gyroscope.data();
    double* accelerometer = from.bias.accelerometer.data();
    own.problem.AddParameterBlock(down_world.data(), 3, &own.direction);
    own.problem.AddResidualBlock(InertialMotion::create(motion),
                                 nullptr,
                                 own.q(from),
                                 from.p_world_imu.data(),
                                 from.velocity_world.data(),
                                 gyroscope,
                                 accelerometer,
                                 own.q(to),
                                 to.p_world_imu.data(),
                                 to.velocity_world.data(),
                                 down_world.data());
    own.order({from.velocity_world.data(), to.velocity_world.data(), down_world.data()});
    const double duration_s = motion.turn.duration_s;
    own.add_walk(gyroscope, to.bias.gyroscope.data(), noise.gyroscope_random_walk, duration_s);
    own.add_walk(
        accelerometer, to.bias.accelerometer.data(), noise.accelerometer_random_walk, duration_s);
}

void Adjustment::add_gyroscope_bias(BodyState& state, const Eigen::Vector3d& known, double sigma) {
    implementation_->add_vector(state.bias.gyroscope, known, sigma);
}

void Adjustment::add_accelerometer_bias(BodyState& state,
                                        const Eigen::Vector3d& known,
                                        double sigma) {
    implementation_->add_vector(state.bias.accelerometer, known, sigma);
}

void Adjustment::fix_gyroscope_bias(BodyState& state) {
    implementation_->problem.SetParameterBlockConstant(state.bias.gyroscope.data());
}

void Adjustment::add_orientation(BodyState& state,
                                 Eigen::Quaterniond& q_world_ahrs,
                                 const Eigen::Quaterniond& q_ahrs_imu,
                                 double sigma_rad) {
    auto& own = *implementation_;
    double* alignment = q_world_ahrs.coeffs().data();
    own.problem.AddParameterBlock(alignment, 4, &own.rotation);
    own.order({alignment});
    own.problem.AddResidualBlock(KnownOrientation::create({q_ahrs_imu, sigma_rad}),
                                 &own.orientation_loss,
                                 alignment,
                                 own.q(state));
}

void Adjustment::add_depth(BodyState& state,
                           Eigen::Vector3d& down_world,
                           double& offset_m,
                           double depth_m,
                           double sigma_m) {
    auto& own = *implementation_;
    own.problem.AddParameterBlock(down_world.data(), 3, &own.direction);
    own.order({down_world.data(), &offset_m});
    own.problem.AddResidualBlock(PressureDepth::create({depth_m, sigma_m}),
                                 &own.depth_loss,
                                 state.p_world_imu.data(),
                                 down_world.data(),
                                 &offset_m);
}

void Adjustment::add_down(Eigen::Vector3d& down_world, const Eigen::Vector3d& known, double sigma) {
    auto& own = *implementation_;
    own.problem.AddParameterBlock(down_world.data(), 3, &own.direction);
    own.add_vector(down_world, known, sigma);
}

void Adjustment::add_prior(const LinearPrior& prior) {
    auto& own = *implementation_;
    for (const auto& block : prior.blocks) {
        const auto size = static_cast<int>(block.at.size());
        ceres::Manifold* manifold = nullptr;
        if (size == 4) manifold = &own.rotation;
        if (size == 3 && block.tangent_size == 2) manifold = &own.direction;
        own.problem.AddParameterBlock(block.values, size, manifold);
        own.order({block.values});
    }
    divemesh::worker::add_prior(own.problem, prior);
}

LinearPrior Adjustment::marginalise(const std::vector<double*>& leaving,
                                    const LinearPrior& before) {
    return divemesh::worker::marginalise(implementation_->problem, leaving, before);
}

void Adjustment::solve(Size size,
                       int max_iterations,
                       const ProgressCallback& progress,
                       const Progress& at) {
    auto& own = *implementation_;
    ceres::Solver::Options options;
    options.linear_solver_type = size == Size::Window ? ceres::DENSE_SCHUR : ceres::SPARSE_SCHUR;
    options.linear_solver_ordering = own.elimination_order(size);
    options.max_num_iterations = max_iterations;
    options.function_tolerance = size == Size::Window ? 1e-4 : 1e-5;
    options.logging_type = ceres::SILENT;
    options.num_threads = 1;
    SolverProgress callback(progress, at);
    options.callbacks.push_back(&callback);
    ceres::Solver::Summary summary;
    ceres::Solve(options, &own.problem, &summary);
    callback.rethrow();
}

std::vector<StateCovariance> Adjustment::covariances(std::vector<BodyState>& states) {
    auto& own = *implementation_;
    std::vector<double*> points;
    for (double* landmark : own.landmarks)
        if (points.empty() || points.back() != landmark) points.push_back(landmark);
    const ReducedInformation information =
        reduced_information(own.problem, own.others, points, kHuberReprojection);
    const auto inverse = SparseInverse::of(information.lower);
    if (!inverse) return {};
    std::unordered_map<const double*, int> start;
    for (std::size_t i = 0; i < own.others.size(); ++i)
        start.emplace(own.others[i], information.start[i]);
    std::vector<StateCovariance> result(states.size());
    for (std::size_t k = 0; k < states.size(); ++k) {
        const int rotation = start.at(own.q(states[k]));
        const int position = start.at(states[k].p_world_imu.data());
        if (position >= 0) result[k].position_m2 = inverse->block(position, 3);
        // Ceres' tangent of a quaternion is half the rotation vector.
        if (rotation >= 0) result[k].rotation_rad2 = 4.0 * inverse->block(rotation, 3);
    }
    return result;
}

}  // namespace divemesh::worker
