#include "worker/estimation/calibration_refinement.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <ceres/loss_function.h>
#include <ceres/manifold.h>
#include <ceres/normal_prior.h>
#include <ceres/problem.h>
#include <ceres/solver.h>
#include <cmath>

#include "worker/estimation/imu_steps.hpp"
#include "worker/estimation/reduced_information.hpp"
#include "worker/estimation/solver_progress.hpp"
#include "worker/estimation/sparse_inverse.hpp"
#include "worker/geometry/rerectifier.hpp"
#include "worker/geometry/rotation_vector.hpp"
#include "worker/residuals/lens_reprojection.hpp"
#include "worker/residuals/misaligned_turn.hpp"
#include "worker/residuals/random_walk.hpp"
#include "worker/residuals/relative_pose.hpp"
#include "worker/steps/feature.hpp"

namespace divemesh::worker {
namespace {

constexpr std::size_t kMostObservations = 20'000;
constexpr std::size_t kFewestKeyframes = 5;
constexpr int kMaxIterations = 10;
constexpr int kMostRounds = 4;
constexpr double kHuber = 1.5;  // sigmas of independent errors
// From round to round: what is linear enough.
constexpr double kConverged_s = 5e-4;
constexpr double kConverged_px = 0.5;
constexpr double kLeastWalk = 1e-6;  // rad/s
constexpr double kBiasSigma = 0.1;   // rad/s
constexpr double kOffsetSigma_s = 0.03;
constexpr double kRotationSigma_rad = 0.035;
// Of a step from keyframe to keyframe: wide enough to say nothing where anything else does.
constexpr double kStepSigma_m = 10.0;
constexpr double kStepSigma_rad = 3.0;
// Features that are followed drift together, which the pictures of a dive cannot tell from another
// focal length: on exact calibrations it comes out wrong by up to 24 of the sigmas that independent
// errors would give. So the pictures count for less here, and careful calibrations for more.
constexpr double kSystematic = 5.0;  // sigmas of a feature, against independent ones
// How far a careful calibration errs.
constexpr double kFocalSigma = 0.001;  // of itself
constexpr double kPrincipalPointSigma_px = 0.5;
constexpr double kDistortionSigma = 0.02;
constexpr double kDistortionShare = 0.15;  // of the coefficient, when that is more

constexpr double kSignificant = 4.0;  // sigmas
constexpr double kLeastOffset_s = 1e-3;
constexpr double kLeastRotation_rad = 1.7e-3;
constexpr double kLeastShift_px = 0.5;

constexpr int kNumChanges = LensReprojection::kNumChanges;
using Changes = Eigen::Matrix<double, kNumChanges, 1>;
using LensCovariance = Eigen::Matrix<double, kNumChanges, kNumChanges>;

struct State {
    Eigen::Quaterniond q_world_body = Eigen::Quaterniond::Identity();
    Eigen::Vector3d p_world_body = Eigen::Vector3d::Zero();
    Eigen::Vector3d gyroscope_bias_imu = Eigen::Vector3d::Zero();  // rad/s
};

struct Unknowns {
    Eigen::Vector3d misalignment = Eigen::Vector3d::Zero();  // rad, q_body_imu as a vector
    double time_offset_s = 0.0;
    Changes lenses = Changes::Zero();  // left, right
};

// Of the unknowns, after the last round.
struct Sigmas {
    Eigen::Matrix3d misalignment = Eigen::Matrix3d::Zero();  // covariance, rad^2
    double time_offset_s = 0.0;
    LensCovariance lenses = LensCovariance::Zero();
};

Changes prior_sigmas(const Rig& rig) {
    Changes sigmas;
    for (int side = 0; side < 2; ++side) {
        const auto& k = (side == 0 ? rig.cam0 : rig.cam1).distortion_coefficients;
        sigmas.segment<LensChange::kSize>(LensChange::kSize * side) << kFocalSigma,
            kPrincipalPointSigma_px, kPrincipalPointSigma_px,
            std::max(kDistortionSigma, kDistortionShare * std::abs(k[0])),
            std::max(kDistortionSigma, kDistortionShare * std::abs(k[1]));
    }
    return sigmas;
}

std::array<LensChange, 2> split(const Changes& changes) {
    return {LensChange{changes.head<LensChange::kSize>()},
            LensChange{changes.tail<LensChange::kSize>()}};
}

// rad/s; the time lies between two samples.
Eigen::Vector3d rate_at(const std::vector<ImuSample>& samples, std::int64_t time_ns) {
    const auto after = std::upper_bound(
        samples.begin() + 1,
        samples.end() - 1,
        time_ns,
        [](std::int64_t time, const ImuSample& sample) { return time < sample.timestamp_ns; });
    return interpolate(*(after - 1), *after, time_ns).angular_velocity_imu;
}

// The dive with its calibration free.
class Problem {
public:
    Problem(const Track& track, const Recording& recording, const InertialPrior& inertial);

    // Rounds of least squares, each linear in a time offset and lenses near those of the last one.
    void solve(bool free_lenses, const ProgressCallback& progress, const Progress& at);
    void hold_lenses(const Changes& changes) { unknowns_.lenses = changes; }
    const Unknowns& unknowns() const { return unknowns_; }
    const Sigmas& sigmas() const { return sigmas_; }
    // How the picture moves with a change of the lenses: its bending, and the disparities', root
    // mean square in px; what a turn of the cameras would do as well is left out.
    double shift_px(const Changes& changes) const;

private:
    // True when it was the last one that is needed, or `last`: then the sigmas are known.
    bool round(bool free_lenses, bool last, const ProgressCallback& progress, const Progress& at);
    void add_observations(ceres::Problem& problem,
                          ceres::ParameterBlockOrdering& ordering,
                          bool free_lenses);
    void add_turns(ceres::Problem& problem);
    // Holds together, as loosely as can be, what no landmark does: where the scene was lost.
    void add_steps(ceres::Problem& problem);
    void add_priors(ceres::Problem& problem, bool free_lenses);
    void find_sigmas(ceres::Problem& problem, bool free_lenses);
    LensReprojection::Shift shift_of(const std::array<RectifiedLens, 2>& lenses,
                                     const Eigen::Vector3d& measured_px) const;
    std::array<RectifiedLens, 2> lenses() const;
    std::vector<double*> kept_blocks();  // all but the landmarks; the unknowns come first
    double* q(State& state) { return state.q_world_body.coeffs().data(); }

    const Track& track_;
    const Recording& recording_;
    const InertialPrior& inertial_;
    Changes prior_sigmas_;
    std::vector<State> states_;
    std::vector<Landmark> landmarks_;
    Unknowns unknowns_;
    Sigmas sigmas_;
    ceres::EigenQuaternionManifold rotation_;
    ceres::HuberLoss loss_{kHuber};
    ceres::HuberLoss lens_loss_{kHuber / kSystematic};
};

Problem::Problem(const Track& track, const Recording& recording, const InertialPrior& inertial)
    : track_(track),
      recording_(recording),
      inertial_(inertial),
      prior_sigmas_(prior_sigmas(recording.rig())) {
    for (const Keyframe& keyframe : track.keyframes) {
        const Eigen::Isometry3d T_world_body = keyframe.T_world_cam * track.rig.T_imu_cam.inverse();
        State& state = states_.emplace_back();
        state.q_world_body = Eigen::Quaterniond(T_world_body.linear()).normalized();
        state.p_world_body = T_world_body.translation();
    }
    std::size_t num_observations = 0;
    for (const Landmark& landmark : track.landmarks)
        num_observations += landmark.observations.size();
    const std::size_t stride = 1 + num_observations / kMostObservations;
    for (std::size_t i = 0; i < track.landmarks.size(); i += stride)
        landmarks_.push_back(track.landmarks[i]);
    unknowns_.time_offset_s = track.imu_alignment.time_offset_s;
    unknowns_.misalignment = vector_from_rotation(track.imu_alignment.q_body_imu);
}

void Problem::solve(bool free_lenses, const ProgressCallback& progress, const Progress& at) {
    for (int i = 0; i < kMostRounds; ++i)
        if (round(free_lenses, i + 1 == kMostRounds, progress, at)) return;
}

bool Problem::round(bool free_lenses,
                    bool last,
                    const ProgressCallback& progress,
                    const Progress& at) {
    const Unknowns before = unknowns_;
    ceres::Problem::Options options;
    options.manifold_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
    options.loss_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
    ceres::Problem problem(options);
    auto ordering = std::make_shared<ceres::ParameterBlockOrdering>();
    for (State& state : states_) {
        problem.AddParameterBlock(q(state), 4, &rotation_);
        problem.AddParameterBlock(state.p_world_body.data(), 3);
    }
    problem.SetParameterBlockConstant(q(states_.front()));
    problem.SetParameterBlockConstant(states_.front().p_world_body.data());
    add_observations(problem, *ordering, free_lenses);
    if (inertial_.has_gyroscope()) add_turns(problem);
    add_steps(problem);
    add_priors(problem, free_lenses);
    for (double* block : kept_blocks())
        if (problem.HasParameterBlock(block)) ordering->AddElementToGroup(block, 1);

    ceres::Solver::Options solver;
    solver.linear_solver_type = ceres::SPARSE_SCHUR;
    solver.linear_solver_ordering = ordering;
    solver.max_num_iterations = kMaxIterations;
    solver.function_tolerance = 1e-5;
    solver.logging_type = ceres::SILENT;
    solver.num_threads = 1;
    SolverProgress callback(progress, at);
    solver.callbacks.push_back(&callback);
    ceres::Solver::Summary summary;
    ceres::Solve(solver, &problem, &summary);
    callback.rethrow();
    const bool still = std::abs(unknowns_.time_offset_s - before.time_offset_s) < kConverged_s &&
                       shift_px(unknowns_.lenses - before.lenses) < kConverged_px;
    if (still || last) find_sigmas(problem, free_lenses);
    return still || last;
}

std::array<RectifiedLens, 2> Problem::lenses() const {
    auto lenses = rectified_lenses(recording_.rig());
    const auto change = split(unknowns_.lenses);
    for (std::size_t side = 0; side < 2; ++side)
        lenses[side].camera = change[side].applied(lenses[side].camera);
    return lenses;
}

LensReprojection::Shift Problem::shift_of(const std::array<RectifiedLens, 2>& lenses,
                                          const Eigen::Vector3d& measured_px) const {
    const auto left = shift_of_change(track_.rig, lenses[0], measured_px.head<2>());
    LensReprojection::Shift shift = LensReprojection::Shift::Zero();
    shift.topLeftCorner<2, LensChange::kSize>() = left;
    if (measured_px.z() <= 0.0) return shift;
    const auto right = shift_of_change(
        track_.rig, lenses[1], {measured_px.x() - measured_px.z(), measured_px.y()});
    shift.bottomLeftCorner<1, LensChange::kSize>() = left.row(0);
    shift.bottomRightCorner<1, LensChange::kSize>() = -right.row(0);
    return shift;
}

void Problem::add_observations(ceres::Problem& problem,
                               ceres::ParameterBlockOrdering& ordering,
                               bool free_lenses) {
    const Eigen::Vector3d sigma_px = (free_lenses ? kSystematic : 1.0) * kFeatureSigma_px;
    const auto lenses = this->lenses();
    const Rerectifier rerectifier(recording_.rig(), track_.rig, split(unknowns_.lenses));
    for (Landmark& landmark : landmarks_) {
        for (const LandmarkObservation& seen : landmark.observations) {
            const Eigen::Vector3d moved =
                rerectifier.moved(Eigen::Vector3d(seen.u_px, seen.v_px, seen.disparity_px));
            LensReprojection residual;
            residual.shift_px = shift_of(lenses, moved);
            residual.stereo = {track_.rig, moved + residual.shift_px * unknowns_.lenses, sigma_px};
            if (moved.z() <= 0.0) residual.stereo.measured_px.z() = 0.0;
            State& state = states_[static_cast<std::size_t>(seen.keyframe)];
            problem.AddResidualBlock(LensReprojection::create(residual),
                                     free_lenses ? &lens_loss_ : &loss_,
                                     q(state),
                                     state.p_world_body.data(),
                                     landmark.p_world.data(),
                                     unknowns_.lenses.data());
        }
        ordering.AddElementToGroup(landmark.p_world.data(), 0);
    }
}

void Problem::add_turns(ceres::Problem& problem) {
    const std::int64_t shift_ns = std::llround(1e9 * unknowns_.time_offset_s);
    const auto& samples = recording_.imu();
    for (std::size_t k = 1; k < states_.size(); ++k) {
        State& from = states_[k - 1];
        State& to = states_[k];
        const std::int64_t from_ns = track_.keyframes[k - 1].timestamp_ns + shift_ns;
        const std::int64_t to_ns = track_.keyframes[k].timestamp_ns + shift_ns;
        const auto integral = integrate_gyroscope(
            samples, from_ns, to_ns, from.gyroscope_bias_imu, inertial_.noise());
        if (!integral) continue;
        const auto rate = [&](std::int64_t time_ns) {
            return Eigen::Vector3d(rate_at(samples, time_ns) - from.gyroscope_bias_imu);
        };
        const Eigen::Vector3d by_time =
            rate(to_ns) - integral->q_from_to.conjugate() * rate(from_ns);
        problem.AddResidualBlock(
            MisalignedTurn::create({*integral, by_time, 1e-9 * static_cast<double>(shift_ns)}),
            nullptr,
            q(from),
            q(to),
            from.gyroscope_bias_imu.data(),
            unknowns_.misalignment.data(),
            &unknowns_.time_offset_s);
        const double walk =
            inertial_.noise().gyroscope_random_walk * std::sqrt(integral->duration_s);
        problem.AddResidualBlock(RandomWalk::create(std::max(kLeastWalk, walk)),
                                 nullptr,
                                 from.gyroscope_bias_imu.data(),
                                 to.gyroscope_bias_imu.data());
    }
}

void Problem::add_steps(ceres::Problem& problem) {
    for (std::size_t k = 1; k < states_.size(); ++k) {
        const Eigen::Isometry3d T_before_now =
            track_.keyframes[k - 1].T_world_cam.inverse() * track_.keyframes[k].T_world_cam;
        const Eigen::Isometry3d T_cam_body = track_.rig.T_imu_cam.inverse();
        problem.AddResidualBlock(
            RelativePose::create(
                T_cam_body.inverse() * T_before_now * T_cam_body, kStepSigma_m, kStepSigma_rad),
            nullptr,
            q(states_[k - 1]),
            states_[k - 1].p_world_body.data(),
            q(states_[k]),
            states_[k].p_world_body.data());
    }
}

void Problem::add_priors(ceres::Problem& problem, bool free_lenses) {
    const auto add = [&](double* block, const Eigen::VectorXd& sigmas) {
        const Eigen::MatrixXd weights = sigmas.cwiseInverse().asDiagonal();
        problem.AddResidualBlock(
            new ceres::NormalPrior(weights, Eigen::VectorXd::Zero(sigmas.size())), nullptr, block);
    };
    add(unknowns_.lenses.data(), prior_sigmas_);
    if (!free_lenses) problem.SetParameterBlockConstant(unknowns_.lenses.data());
    if (!problem.HasParameterBlock(&unknowns_.time_offset_s)) return;
    add(&unknowns_.time_offset_s, Eigen::VectorXd::Constant(1, kOffsetSigma_s));
    add(unknowns_.misalignment.data(), Eigen::Vector3d::Constant(kRotationSigma_rad));
    for (State& state : states_) {
        if (!problem.HasParameterBlock(state.gyroscope_bias_imu.data())) continue;
        add(state.gyroscope_bias_imu.data(), Eigen::Vector3d::Constant(kBiasSigma));
        break;
    }
}

std::vector<double*> Problem::kept_blocks() {
    std::vector<double*> blocks = {
        unknowns_.lenses.data(), unknowns_.misalignment.data(), &unknowns_.time_offset_s};
    for (State& state : states_)
        for (double* block : {q(state), state.p_world_body.data(), state.gyroscope_bias_imu.data()})
            blocks.push_back(block);
    return blocks;
}

void Problem::find_sigmas(ceres::Problem& problem, bool free_lenses) {
    std::vector<double*> kept;
    for (double* block : kept_blocks())
        if (problem.HasParameterBlock(block)) kept.push_back(block);
    std::vector<double*> points;
    for (Landmark& landmark : landmarks_) points.push_back(landmark.p_world.data());
    const ReducedInformation information =
        reduced_information(problem, kept, points, free_lenses ? kHuber / kSystematic : kHuber);
    const auto inverse = SparseInverse::of(information.lower);
    if (!inverse) return;
    const auto covariance = [&](const double* block, int size) -> Eigen::MatrixXd {
        const auto at = std::find(kept.begin(), kept.end(), block) - kept.begin();
        const int start =
            at < std::ssize(kept) ? information.start[static_cast<std::size_t>(at)] : -1;
        return start < 0 ? Eigen::MatrixXd::Zero(size, size) : inverse->block(start, size);
    };
    sigmas_.lenses = covariance(unknowns_.lenses.data(), kNumChanges);
    sigmas_.misalignment = covariance(unknowns_.misalignment.data(), 3);
    sigmas_.time_offset_s = std::sqrt(covariance(&unknowns_.time_offset_s, 1)(0, 0));
}

double Problem::shift_px(const Changes& changes) const {
    constexpr int kSteps = 8;
    const auto lenses = rectified_lenses(recording_.rig());
    Eigen::Vector3d mean = Eigen::Vector3d::Zero();
    Eigen::Vector3d squares = Eigen::Vector3d::Zero();
    for (int i = 0; i <= kSteps; ++i) {
        for (int j = 0; j <= kSteps; ++j) {
            const Eigen::Vector3d measured_px(
                static_cast<double>(i) / kSteps * (track_.rig.width_px - 1),
                static_cast<double>(j) / kSteps * (track_.rig.height_px - 1),
                1.0);
            const Eigen::Vector3d shift = shift_of(lenses, measured_px) * changes;
            mean += shift;
            squares += shift.cwiseAbs2();
        }
    }
    constexpr double kNum = (kSteps + 1) * (kSteps + 1);
    mean /= kNum;
    mean.z() = 0.0;  // of the disparities the mean is an error of depth
    return (squares / kNum - mean.cwiseAbs2()).cwiseMax(0.0).cwiseSqrt().maxCoeff();
}

bool significant(const Eigen::VectorXd& value, const Eigen::MatrixXd& covariance) {
    return value.dot(covariance.ldlt().solve(value)) >
           kSignificant * kSignificant * static_cast<double>(value.size());
}

struct Distortions {
    Changes changes = Changes::Zero();  // of k1 and k2 alone
    bool significant = false;
};

// The distortion when focal lengths and principal points are as stated: the mean and the covariance
// of a part of the normal distribution, given the rest.
Distortions distortion_alone(const Changes& found, const LensCovariance& covariance) {
    constexpr std::array<int, 4> kBent = {3, 4, 8, 9};
    constexpr std::array<int, 6> kRest = {0, 1, 2, 5, 6, 7};
    const Eigen::Matrix4d own = covariance(kBent, kBent);
    const Eigen::Matrix<double, 4, 6> cross = covariance(kBent, kRest);
    const Eigen::Matrix<double, 6, 6> rest = covariance(kRest, kRest);
    const Eigen::Matrix<double, 4, 6> gain =
        rest.ldlt().solve(Eigen::Matrix<double, 6, 4>(cross.transpose())).transpose();
    const Eigen::Vector4d mean =
        Eigen::Vector4d(found(kBent)) - gain * Eigen::Matrix<double, 6, 1>(found(kRest));
    Distortions result;
    result.changes(kBent) = mean;
    result.significant = significant(mean, own - gain * cross.transpose());
    return result;
}

void take_imu(const Problem& problem, RefinedCalibration& result) {
    const Unknowns& found = problem.unknowns();
    const Sigmas& sigmas = problem.sigmas();
    result.imu = {found.time_offset_s, rotation_from_vector(found.misalignment)};
    result.time_offset_sigma_s = sigmas.time_offset_s;
    result.rotation_sigma_rad = sigmas.misalignment.diagonal().cwiseMax(0.0).cwiseSqrt();
    result.time_offset_applied = std::abs(found.time_offset_s) >
                                 std::max(kLeastOffset_s, kSignificant * sigmas.time_offset_s);
    result.rotation_applied = found.misalignment.norm() > kLeastRotation_rad &&
                              significant(found.misalignment, sigmas.misalignment);
}

}  // namespace

ImuAlignment RefinedCalibration::applied_alignment() const {
    ImuAlignment applied;
    if (time_offset_applied) applied.time_offset_s = imu.time_offset_s;
    if (rotation_applied) applied.q_body_imu = imu.q_body_imu;
    return applied;
}

RefinedCalibration refine_calibration(const Track& track,
                                      const Recording& recording,
                                      const ReconstructionOptions& options,
                                      const InertialPrior& inertial,
                                      const ProgressCallback& progress,
                                      const Progress& at) {
    RefinedCalibration result;
    if (track.keyframes.size() < kFewestKeyframes || track.landmarks.empty()) return result;
    Problem problem(track, recording, inertial);
    const bool align = options.align_imu && inertial.has_gyroscope();
    if (align) {
        problem.solve(false, progress, at);
        take_imu(problem, result);
    }
    if (!options.refine_lenses) return result;
    problem.solve(true, progress, at);
    const Changes found = problem.unknowns().lenses;
    const LensCovariance covariance = problem.sigmas().lenses;
    const Changes sigmas = covariance.diagonal().cwiseMax(0.0).cwiseSqrt();
    result.lenses = split(found);
    result.lens_sigmas = {sigmas.head<LensChange::kSize>(), sigmas.tail<LensChange::kSize>()};
    const Distortions bent = distortion_alone(found, covariance);
    result.applied_lenses = split(bent.changes);
    result.lens_shift_px = problem.shift_px(bent.changes);
    result.lenses_applied = result.lens_shift_px > kLeastShift_px && bent.significant;
    if (result.lenses_applied && align) {
        problem.hold_lenses(bent.changes);
        problem.solve(false, progress, at);
        take_imu(problem, result);
    }
    return result;
}

void apply_calibration(const Rig& rig, const RefinedCalibration& calibration, Track& track) {
    const RectifiedRig rectified = track.rig;
    if (calibration.rotation_applied) {
        const Eigen::Isometry3d T_body_imu(calibration.imu.q_body_imu);
        track.rig.T_imu_cam = T_body_imu.inverse() * track.rig.T_imu_cam;
        for (StampedPose& pose : track.odometry) pose.T_world_imu = pose.T_world_imu * T_body_imu;
    }
    if (!calibration.lenses_applied) return;
    const Rerectifier rerectifier(rig, rectified, calibration.applied_lenses);
    for (Landmark& landmark : track.landmarks) {
        for (LandmarkObservation& seen : landmark.observations) {
            const Eigen::Vector3f moved =
                rerectifier.moved(Eigen::Vector3d(seen.u_px, seen.v_px, seen.disparity_px))
                    .cast<float>();
            seen.u_px = moved.x();
            seen.v_px = moved.y();
            seen.disparity_px = moved.z();
        }
    }
}

}  // namespace divemesh::worker
