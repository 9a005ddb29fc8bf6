#include "worker/calibration/calibration_problem.hpp"

#include <algorithm>
#include <ceres/iteration_callback.h>
#include <ceres/normal_prior.h>
#include <ceres/solver.h>
#include <cmath>
#include <limits>
#include <utility>

#include "worker/base/rotation_vector.hpp"
#include "worker/base/seconds.hpp"
#include "worker/calibration/undo_rolling_shutter.hpp"
#include "worker/camera/rerectifier.hpp"
#include "worker/imu/imu_steps.hpp"
#include "worker/optimisation/ceres_outcome.hpp"
#include "worker/optimisation/reduced_information.hpp"
#include "worker/optimisation/residuals/misaligned_gyro_rotation_cost.hpp"
#include "worker/optimisation/residuals/random_walk.hpp"
#include "worker/optimisation/residuals/relative_pose.hpp"
#include "worker/optimisation/solver_progress.hpp"
#include "worker/optimisation/sparse_inverse.hpp"
#include "worker/types/feature.hpp"

namespace divemesh::calibration {
namespace {

constexpr std::size_t kMaxObservations = 20'000;
constexpr int kMaxIterations = 10;
constexpr double kHuber = 1.5;  // sigmas of independent errors
// Change from round to round below which the linearisation is good enough.
constexpr double kConverged_s = 5e-4;
constexpr double kConverged_px = 0.5;
constexpr double kMinWalk = 1e-6;   // rad/s
constexpr double kBiasSigma = 0.1;  // rad/s
constexpr double kOffsetSigma_s = 0.03;
constexpr double kRotationSigma_rad = 0.035;
constexpr double kReadoutSigma_s = 0.03;  // a frame takes 33 ms at the usual rate
// The prior of a step between keyframes. It is so wide that it has no effect where anything else
// constrains the step.
constexpr double kStepSigma_m = 10.0;
constexpr double kStepSigma_rad = 3.0;
// Tracked features drift together, and the images of a dive cannot tell that drift from another
// focal length. On exact calibrations the error of the focal length is up to 24 times the sigma of
// independent errors. So images get less weight here, and careful calibrations more.
constexpr double kSystematic = 5.0;  // sigma of a feature relative to that of independent errors

// Returns the angular velocity, rad/s; the time must lie between two samples.
Eigen::Vector3d rate_at(const std::vector<types::ImuSample>& samples, std::int64_t time_ns) {
    const auto after = std::upper_bound(samples.begin() + 1,
                                        samples.end() - 1,
                                        time_ns,
                                        [](std::int64_t time, const types::ImuSample& sample) {
                                            return time < sample.timestamp_ns;
                                        });
    return imu::interpolate(*(after - 1), *after, time_ns).angular_velocity_imu;
}

// Records the unknowns before the last step that the solver took.
class UnknownsRecorder : public ceres::IterationCallback {
public:
    explicit UnknownsRecorder(const CalibrationUnknowns& now)
        : now_(now), before_(now), after_(now) {}

    ceres::CallbackReturnType operator()(const ceres::IterationSummary& iteration) override {
        if (iteration.iteration == 0 || !iteration.step_is_successful)
            return ceres::SOLVER_CONTINUE;
        before_ = std::exchange(after_, now_);
        return ceres::SOLVER_CONTINUE;
    }
    const CalibrationUnknowns& before_last_step() const { return before_; }

private:
    const CalibrationUnknowns& now_;
    CalibrationUnknowns before_;
    CalibrationUnknowns after_;
};

}  // namespace

std::array<types::LensChange, 2> split(const LensChanges& changes) {
    return {types::LensChange{changes.head<types::LensChange::kSize>()},
            types::LensChange{changes.tail<types::LensChange::kSize>()}};
}

CalibrationProblem::CalibrationProblem(const types::Track& track,
                                       const types::Recording& recording,
                                       const types::RigAlignment& alignment,
                                       const imu::InertialPrior& inertial)
    : track_(track),
      recording_(recording),
      inertial_(inertial),
      prior_sigmas_(lens_prior_sigmas(recording.rig(), alignment)),
      shutter_(track.rig, camera::rectified_lenses(recording.rig())[0]),
      motions_(camera_motions(track, track.keyframes)),
      loss_(kHuber),
      lens_loss_(kHuber / kSystematic) {
    for (const types::Keyframe& keyframe : track.keyframes) {
        const Eigen::Isometry3d T_world_body = keyframe.T_world_cam * track.rig.T_imu_cam.inverse();
        State& state = states_.emplace_back();
        state.q_world_body = Eigen::Quaterniond(T_world_body.linear()).normalized();
        state.p_world_body = T_world_body.translation();
    }
    std::size_t num_observations = 0;
    for (const types::Landmark& landmark : track.landmarks)
        num_observations += landmark.observations.size();
    const std::size_t stride = 1 + num_observations / kMaxObservations;
    for (std::size_t i = 0; i < track.landmarks.size(); i += stride)
        landmarks_.push_back(track.landmarks[i]);
    unknowns_.time_offset_s = track.imu_alignment.time_offset_s;
    unknowns_.misalignment = base::vector_from_rotation(track.imu_alignment.q_body_imu);
}

types::SolverOutcome CalibrationProblem::solve(const FreeUnknowns& free,
                                               const base::ProgressCallback& progress,
                                               const Progress& at,
                                               int max_rounds) {
    using Termination = types::SolverOutcome::Termination;
    types::SolverOutcome whole;
    for (int i = 1; i <= max_rounds; ++i) {
        const CalibrationUnknowns before = unknowns_;
        Round done = round(free, i == max_rounds, progress, at);
        if (i > 1) done.outcome.initial_cost = whole.initial_cost;
        done.outcome.num_iterations += whole.num_iterations;
        whole = std::move(done.outcome);
        if (whole.failed()) return whole;
        // The sigmas are known after the last round only.
        if (done.still) {
            whole.last_step_sigmas = moved_sigmas(done.before_last_step);
            return whole;
        }
        if (i == max_rounds) whole.last_step_sigmas = moved_sigmas(before);
    }
    whole.termination = Termination::StoppedAtLimit;
    whole.message = "the calibration still moved in the last round";
    return whole;
}

CalibrationProblem::Round CalibrationProblem::round(const FreeUnknowns& free,
                                                    bool last,
                                                    const base::ProgressCallback& progress,
                                                    const Progress& at) {
    const CalibrationUnknowns before = unknowns_;
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
    add_observations(problem, *ordering, free);
    if (inertial_.has_gyroscope()) add_gyro_rotations(problem);
    add_odometry(problem);
    add_priors(problem, free);
    for (double* block : kept_blocks())
        if (problem.HasParameterBlock(block)) ordering->AddElementToGroup(block, 1);

    ceres::Solver::Options solver;
    solver.linear_solver_type = ceres::SPARSE_SCHUR;
    solver.linear_solver_ordering = ordering;
    solver.max_num_iterations = kMaxIterations;
    solver.function_tolerance = 1e-5;
    solver.logging_type = ceres::SILENT;
    solver.num_threads = 1;
    optimisation::SolverProgress callback(progress, at);
    UnknownsRecorder recorder(unknowns_);
    solver.callbacks = {&callback, &recorder};
    solver.update_state_every_iteration = true;
    ceres::Solver::Summary summary;
    ceres::Solve(solver, &problem, &summary);
    callback.rethrow();
    const bool still = std::abs(unknowns_.time_offset_s - before.time_offset_s) < kConverged_s &&
                       std::abs(unknowns_.readout_time_s - before.readout_time_s) < kConverged_s &&
                       shift_px(unknowns_.lenses - before.lenses) < kConverged_px;
    types::SolverOutcome outcome = optimisation::outcome_of(summary);
    if ((still || last) && !outcome.failed() && !find_sigmas(problem, free)) {
        outcome.termination = types::SolverOutcome::Termination::Failed;
        outcome.message = "the measurements do not determine all unknowns";
    }
    return {outcome, still, recorder.before_last_step()};
}

std::array<camera::RectifiedLens, 2> CalibrationProblem::lenses() const {
    auto lenses = camera::rectified_lenses(recording_.rig());
    const auto change = split(unknowns_.lenses);
    for (std::size_t side = 0; side < 2; ++side)
        lenses[side].camera = camera::changed_camera(lenses[side].camera, change[side]);
    return lenses;
}

LensReprojection::Shift CalibrationProblem::shift_of(
    const std::array<camera::RectifiedLens, 2>& lenses, const Eigen::Vector3d& measured_px) const {
    const auto left = camera::shift_of_change(track_.rig, lenses[0], measured_px.head<2>());
    LensReprojection::Shift shift = LensReprojection::Shift::Zero();
    shift.topLeftCorner<2, types::LensChange::kSize>() = left;
    if (measured_px.z() <= 0.0) return shift;
    const auto right = camera::shift_of_change(
        track_.rig, lenses[1], {measured_px.x() - measured_px.z(), measured_px.y()});
    shift.bottomLeftCorner<1, types::LensChange::kSize>() = left.row(0);
    shift.bottomRightCorner<1, types::LensChange::kSize>() = -right.row(0);
    return shift;
}

void CalibrationProblem::add_observations(ceres::Problem& problem,
                                          ceres::ParameterBlockOrdering& ordering,
                                          const FreeUnknowns& free) {
    const Eigen::Vector3d sigma_px = (free.any() ? kSystematic : 1.0) * types::kFeatureSigma_px;
    const auto lenses = this->lenses();
    const camera::Rerectifier rerectifier(recording_.rig(), track_.rig, split(unknowns_.lenses));
    for (std::size_t i = 0; i < landmarks_.size(); i += stride_) {
        types::Landmark& landmark = landmarks_[i];
        for (const types::LandmarkObservation& seen : landmark.observations) {
            const Eigen::Vector3d moved =
                rerectifier.moved(Eigen::Vector3d(seen.u_px, seen.v_px, seen.disparity_px));
            LensReprojection residual;
            residual.shift_px = shift_of(lenses, moved);
            residual.stereo = {track_.rig, moved + residual.shift_px * unknowns_.lenses, sigma_px};
            if (moved.z() <= 0.0) residual.stereo.measured_px.z() = 0.0;
            residual.by_readout_px_s = shift_by_readout_px_s(landmark, seen);
            State& state = states_[static_cast<std::size_t>(seen.keyframe)];
            problem.AddResidualBlock(LensReprojection::create(residual),
                                     free.any() ? &lens_loss_ : &loss_,
                                     q(state),
                                     state.p_world_body.data(),
                                     landmark.p_world.data(),
                                     unknowns_.lenses.data(),
                                     &unknowns_.readout_time_s);
        }
        ordering.AddElementToGroup(landmark.p_world.data(), 0);
    }
}

void CalibrationProblem::add_gyro_rotations(ceres::Problem& problem) {
    const std::int64_t shift_ns = base::to_ns(unknowns_.time_offset_s);
    const auto& samples = inertial_.rates();
    for (std::size_t k = 1; k < states_.size(); ++k) {
        State& from = states_[k - 1];
        State& to = states_[k];
        const std::int64_t from_ns = track_.keyframes[k - 1].timestamp_ns + shift_ns;
        const std::int64_t to_ns = track_.keyframes[k].timestamp_ns + shift_ns;
        const auto integral = imu::integrate_gyroscope(
            samples, from_ns, to_ns, from.gyroscope_bias_imu, inertial_.noise());
        if (!integral) continue;
        const auto rate = [&](std::int64_t time_ns) {
            return Eigen::Vector3d(rate_at(samples, time_ns) - from.gyroscope_bias_imu);
        };
        const Eigen::Vector3d by_time =
            rate(to_ns) - integral->q_from_to.conjugate() * rate(from_ns);
        problem.AddResidualBlock(optimisation::MisalignedGyroRotationCost::create(
                                     {*integral, by_time, base::to_s(shift_ns)}),
                                 nullptr,
                                 q(from),
                                 q(to),
                                 from.gyroscope_bias_imu.data(),
                                 unknowns_.misalignment.data(),
                                 &unknowns_.time_offset_s,
                                 unknowns_.rate_error.data());
        const double walk =
            inertial_.noise().gyroscope_random_walk * std::sqrt(integral->duration_s);
        problem.AddResidualBlock(optimisation::RandomWalk::create(std::max(kMinWalk, walk)),
                                 nullptr,
                                 from.gyroscope_bias_imu.data(),
                                 to.gyroscope_bias_imu.data());
    }
}

void CalibrationProblem::add_odometry(ceres::Problem& problem) {
    for (std::size_t k = 1; k < states_.size(); ++k) {
        const Eigen::Isometry3d T_before_now =
            track_.keyframes[k - 1].T_world_cam.inverse() * track_.keyframes[k].T_world_cam;
        const Eigen::Isometry3d T_cam_body = track_.rig.T_imu_cam.inverse();
        problem.AddResidualBlock(
            optimisation::RelativePose::create(
                T_cam_body.inverse() * T_before_now * T_cam_body, kStepSigma_m, kStepSigma_rad),
            nullptr,
            q(states_[k - 1]),
            states_[k - 1].p_world_body.data(),
            q(states_[k]),
            states_[k].p_world_body.data());
    }
}

void CalibrationProblem::add_priors(ceres::Problem& problem, const FreeUnknowns& free) {
    const auto add_around =
        [&](const Eigen::VectorXd& mean, const Eigen::VectorXd& sigmas, double* block) {
            const Eigen::MatrixXd weights = sigmas.cwiseInverse().asDiagonal();
            problem.AddResidualBlock(new ceres::NormalPrior(weights, mean), nullptr, block);
        };
    const auto add = [&](double* block, const Eigen::VectorXd& sigmas) {
        add_around(Eigen::VectorXd::Zero(sigmas.size()), sigmas, block);
    };
    add(unknowns_.lenses.data(), prior_sigmas_);
    if (!free.lenses) problem.SetParameterBlockConstant(unknowns_.lenses.data());
    add(&unknowns_.readout_time_s, Eigen::VectorXd::Constant(1, kReadoutSigma_s));
    if (!free.readout_time) problem.SetParameterBlockConstant(&unknowns_.readout_time_s);
    if (!problem.HasParameterBlock(&unknowns_.time_offset_s)) return;
    add_around(Eigen::VectorXd::Constant(1, track_.imu_alignment.time_offset_s),
               Eigen::VectorXd::Constant(1, kOffsetSigma_s),
               &unknowns_.time_offset_s);
    add(unknowns_.misalignment.data(), Eigen::Vector3d::Constant(kRotationSigma_rad));
    add(unknowns_.rate_error.data(), Eigen::Vector3d::Constant(kRateErrorSigma));
    if (free.any()) problem.SetParameterBlockConstant(unknowns_.rate_error.data());
    for (State& state : states_) {
        if (!problem.HasParameterBlock(state.gyroscope_bias_imu.data())) continue;
        add(state.gyroscope_bias_imu.data(), Eigen::Vector3d::Constant(kBiasSigma));
        break;
    }
}

std::vector<double*> CalibrationProblem::kept_blocks() {
    std::vector<double*> blocks = {unknowns_.lenses.data(),
                                   &unknowns_.readout_time_s,
                                   unknowns_.misalignment.data(),
                                   &unknowns_.time_offset_s,
                                   unknowns_.rate_error.data()};
    for (State& state : states_)
        for (double* block : {q(state), state.p_world_body.data(), state.gyroscope_bias_imu.data()})
            blocks.push_back(block);
    return blocks;
}

bool CalibrationProblem::find_sigmas(ceres::Problem& problem, const FreeUnknowns& free) {
    std::vector<double*> kept;
    for (double* block : kept_blocks())
        if (problem.HasParameterBlock(block)) kept.push_back(block);
    std::vector<double*> points;
    for (std::size_t i = 0; i < landmarks_.size(); i += stride_)
        points.push_back(landmarks_[i].p_world.data());
    const optimisation::ReducedInformation information = optimisation::reduced_information(
        problem, kept, points, free.any() ? kHuber / kSystematic : kHuber);
    const auto inverse = optimisation::SparseInverse::of(information.lower);
    if (!inverse) return false;
    const auto covariance = [&](const double* block, int size) -> Eigen::MatrixXd {
        const auto at = std::find(kept.begin(), kept.end(), block) - kept.begin();
        const int start =
            at < std::ssize(kept) ? information.start[static_cast<std::size_t>(at)] : -1;
        return start < 0 ? Eigen::MatrixXd::Zero(size, size) : inverse->block(start, size);
    };
    sigmas_.lenses = covariance(unknowns_.lenses.data(), LensReprojection::kNumChanges);
    sigmas_.misalignment = covariance(unknowns_.misalignment.data(), 3);
    sigmas_.time_offset_s = std::sqrt(covariance(&unknowns_.time_offset_s, 1)(0, 0));
    sigmas_.rate_error = covariance(unknowns_.rate_error.data(), 3);
    sigmas_.readout_time_s = std::sqrt(covariance(&unknowns_.readout_time_s, 1)(0, 0));
    return true;
}

double CalibrationProblem::moved_sigmas(const CalibrationUnknowns& before) const {
    const auto rms = [](const auto& moved, const auto& covariance) {
        const double squared = moved.dot(covariance.ldlt().solve(moved));
        if (!(squared >= 0.0)) return std::numeric_limits<double>::infinity();  // no covariance
        return std::sqrt(squared / static_cast<double>(moved.size()));
    };
    double sigmas = 0.0;
    if (sigmas_.time_offset_s > 0.0)
        sigmas = std::abs(unknowns_.time_offset_s - before.time_offset_s) / sigmas_.time_offset_s;
    if (!sigmas_.misalignment.isZero(0.0))
        sigmas = std::max(sigmas,
                          rms(Eigen::Vector3d(unknowns_.misalignment - before.misalignment),
                              sigmas_.misalignment));
    if (!sigmas_.rate_error.isZero(0.0))
        sigmas = std::max(
            sigmas,
            rms(Eigen::Vector3d(unknowns_.rate_error - before.rate_error), sigmas_.rate_error));
    if (!sigmas_.lenses.isZero(0.0))
        sigmas =
            std::max(sigmas, rms(LensChanges(unknowns_.lenses - before.lenses), sigmas_.lenses));
    if (sigmas_.readout_time_s > 0.0)
        sigmas = std::max(
            sigmas,
            std::abs(unknowns_.readout_time_s - before.readout_time_s) / sigmas_.readout_time_s);
    return sigmas;
}

Eigen::Vector3d CalibrationProblem::shift_by_readout_px_s(
    const types::Landmark& landmark, const types::LandmarkObservation& seen) const {
    const auto keyframe = static_cast<std::size_t>(seen.keyframe);
    if (!motions_[keyframe]) return Eigen::Vector3d::Zero();
    const State& state = states_[keyframe];
    const Eigen::Vector3d p_body =
        state.q_world_body.conjugate() * (landmark.p_world - state.p_world_body);
    return shutter_.shift_px_s(
        *motions_[keyframe], {seen.u_px, seen.v_px}, track_.rig.T_imu_cam.inverse() * p_body);
}

bool CalibrationProblem::knows_motion() const {
    return std::ranges::any_of(motions_, [](const auto& motion) { return motion.has_value(); });
}

double CalibrationProblem::shift_by_readout_px(double readout_time_s) const {
    double squares_px2 = 0.0;
    double num = 0.0;
    for (const types::Landmark& landmark : landmarks_) {
        for (const types::LandmarkObservation& seen : landmark.observations) {
            squares_px2 += (readout_time_s * shift_by_readout_px_s(landmark, seen)).squaredNorm();
            num += 1.0;
        }
    }
    return num > 0.0 ? std::sqrt(squares_px2 / num) : 0.0;
}

double CalibrationProblem::shift_px(const LensChanges& changes) const {
    constexpr int kSteps = 8;
    const auto lenses = camera::rectified_lenses(recording_.rig());
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
    mean.z() = 0.0;  // the mean disparity is not removed: it is an error of depth
    return (squares / kNum - mean.cwiseAbs2()).cwiseMax(0.0).cwiseSqrt().maxCoeff();
}

}  // namespace divemesh::calibration
