#include "worker/calibration/epipolar_problem.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <utility>

#include "worker/base/rotation_vector.hpp"
#include "worker/camera/rectified_lens.hpp"
#include "worker/stats/median.hpp"
#include "worker/stats/robust.hpp"

namespace divemesh::calibration {
namespace {

constexpr int kNumSteps = 12;
constexpr int kNumPlainSteps = 3;  // at equal weights, to come near enough for the robust ones
constexpr double kMinError_px = 0.05;
// How far a rig may have been knocked: a degree, and a millimetre of a baseline of 120 mm.
constexpr double kRotationSigma_rad = 0.0175;
constexpr double kBaselineSigma_rad = 0.0087;
constexpr double kCentreSigma_px = 1.0;       // rows do not tell it
constexpr double kCentreDownSigma_px = 10.0;  // images that were shifted or cropped
constexpr double kFocalSigma = 0.003;         // difference of the cameras, as calibrations leave it
// Each lens term at the border of the image: as real rigs have them, and as the best have.
constexpr double kMaxLensSigma_px = 0.3;
constexpr double kMinLensSigma_px = 0.01;
constexpr int kNumLensRounds = 3;

EpipolarUnknowns prior_sigmas(double lens_sigma_px) {
    EpipolarUnknowns sigmas;
    sigmas << Eigen::Vector3d::Constant(kRotationSigma_rad),
        Eigen::Vector2d::Constant(kBaselineSigma_rad), kFocalSigma, kCentreSigma_px,
        kCentreDownSigma_px, LensTerms::Constant(lens_sigma_px);
    return sigmas;
}

// Returns how far a ray moves by a pixel's shift.
Eigen::Vector3d ray_shift(const types::RectifiedRig& rig, const Eigen::Vector2d& shift_px) {
    return {shift_px.x() / rig.focal_px, shift_px.y() / rig.focal_px, 0.0};
}

LensTerms lens_terms(const types::RectifiedRig& rig, const Eigen::Vector2d& right_px) {
    const double u = 2.0 * right_px.x() / rig.width_px - 1.0;
    const double v = 2.0 * right_px.y() / rig.height_px - 1.0;
    LensTerms terms;
    terms << u * u, u * v, v * v, u * u * u, u * u * v, u * v * v, v * v * v;
    return terms;
}

double robust_sigma(const std::vector<double>& errors) {
    std::vector<double> sizes(errors.size());
    std::ranges::transform(errors, sizes.begin(), [](double error) { return std::abs(error); });
    return std::max(kMinError_px, stats::kSigmasPerMad * stats::upper_median(std::move(sizes)));
}

}  // namespace

double EpipolarProblem::step_sigmas(const EpipolarUnknowns& step,
                                    const EpipolarCovariance& information,
                                    const Held& held) {
    return std::sqrt(step.dot(information * step) /
                     static_cast<double>(std::ranges::count(held, false)));
}

EpipolarProblem::EpipolarProblem(const types::Rig& rig,
                                 const types::RectifiedRig& rectified,
                                 const types::StereoMatches& matches)
    : focal_px_(rectified.focal_px) {
    const camera::RectifiedLens right = camera::rectified_lenses(rig)[1];
    R_rectified_right_ = right.R_camera_rectified.transpose();
    samples_.reserve(matches.size());
    for (const types::StereoMatch& match : matches) {
        const auto shifts_px = camera::shift_of_change(rectified, right, match.right_px);
        samples_.push_back({match.frame_index,
                            rectified.point_cam(match.left_px.x(), match.left_px.y(), 1.0),
                            rectified.point_cam(match.right_px.x(), match.right_px.y(), 1.0),
                            ray_shift(rectified, shifts_px.col(types::LensChange::kFocal)),
                            ray_shift(rectified, shifts_px.col(types::LensChange::kCentreDown)),
                            lens_terms(rectified, match.right_px)});
    }
}

EpipolarProblem::Moved EpipolarProblem::moved(const EpipolarUnknowns& values) const {
    return {base::rotation_from_vector(R_rectified_right_ * values.head<3>()).toRotationMatrix(),
            {1.0, values[3], values[4]},
            values};
}

// Returns the right ray in the frame of the rectified left camera.
Eigen::Vector3d EpipolarProblem::right_ray(const Sample& sample, const Moved& rig) {
    return rig.R *
           (sample.right_ray - rig.values[types::RigChange::kFocal] * sample.right_by_focal -
            rig.values[types::RigChange::kCentreDown] * sample.right_by_centre_down);
}

double EpipolarProblem::error_px(const Sample& sample,
                                 const Moved& rig,
                                 const Eigen::Vector3d& across) const {
    return focal_px_ * rig.baseline.dot(across) -
           sample.lens_terms.dot(rig.values.tail<kNumLensTerms>());
}

EpipolarProblem::Residual EpipolarProblem::residual(const Sample& sample, const Moved& rig) const {
    const Eigen::Vector3d right = right_ray(sample, rig);
    const Eigen::Vector3d across = sample.left_ray.cross(right);
    const Eigen::Vector3d normal = rig.baseline.cross(sample.left_ray);
    Residual result;
    result.error_px = error_px(sample, rig, across);
    result.gradient << focal_px_ * R_rectified_right_.transpose() * right.cross(normal),
        focal_px_ * across.tail<2>(), -focal_px_ * normal.dot(rig.R * sample.right_by_focal), 0.0,
        -focal_px_ * normal.dot(rig.R * sample.right_by_centre_down), -sample.lens_terms;
    return result;
}

std::vector<double> EpipolarProblem::errors_px(const EpipolarUnknowns& values) const {
    const Moved rig = moved(values);
    std::vector<double> errors;
    errors.reserve(samples_.size());
    for (const Sample& sample : samples_)
        errors.push_back(error_px(sample, rig, sample.left_ray.cross(right_ray(sample, rig))));
    return errors;
}

EpipolarProblem::NormalEquations EpipolarProblem::equations(
    const EpipolarSolution& at, const Held& held, const EpipolarUnknowns& prior_sigmas) const {
    NormalEquations result;
    const Moved rig = moved(at.values);
    EpipolarUnknowns of_pair = EpipolarUnknowns::Zero();
    for (std::size_t i = 0; i < samples_.size(); ++i) {
        Residual found = residual(samples_[i], rig);
        for (int k = 0; k < kNumEpipolarUnknowns; ++k)
            if (held[static_cast<std::size_t>(k)]) found.gradient[k] = 0.0;
        const double weight = at.weights[i] / (at.error_px * at.error_px);
        result.information += weight * found.gradient * found.gradient.transpose();
        of_pair += weight * found.error_px * found.gradient;
        if (i + 1 < samples_.size() && samples_[i + 1].frame_index == samples_[i].frame_index)
            continue;
        result.gradient += of_pair;
        result.between_pairs += of_pair * of_pair.transpose();
        of_pair.setZero();
    }
    const EpipolarUnknowns prior = prior_sigmas.cwiseAbs2().cwiseInverse();
    result.information.diagonal() += prior;
    result.gradient += prior.cwiseProduct(at.values);
    return result;
}

double EpipolarProblem::cost(const EpipolarUnknowns& values,
                             double error_px,
                             const EpipolarUnknowns& prior_sigmas) const {
    double sum = 0.0;
    for (const double error : errors_px(values))
        sum += stats::tukey_loss(error / error_px, stats::kTukey);
    return sum + 0.5 * values.cwiseQuotient(prior_sigmas).squaredNorm();
}

EpipolarSolution EpipolarProblem::solve(const Held& held) const {
    double lens_sigma_px = kMaxLensSigma_px;
    Solved solved = solve(held, lens_sigma_px);
    EpipolarUnknowns before;
    for (int round = 1; round < kNumLensRounds; ++round) {
        before = solved.solution.values;
        const double found_px = before.tail<kNumLensTerms>().norm() / std::sqrt(kNumLensTerms);
        lens_sigma_px = std::clamp(found_px, kMinLensSigma_px, kMaxLensSigma_px);
        const int num_steps = solved.steps.num_steps;
        solved = solve(held, lens_sigma_px);
        solved.steps.num_steps += num_steps;
    }
    const EpipolarUnknowns moved = solved.solution.values - before;
    solved.steps.last_step_sigmas =
        std::max(solved.steps.last_step_sigmas, step_sigmas(moved, solved.information, held));
    solved.solution.outcome = optimisation::outcome_of(solved.steps);
    return solved.solution;
}

EpipolarProblem::Solved EpipolarProblem::solve(const Held& held, double lens_sigma_px) const {
    const EpipolarUnknowns prior = prior_sigmas(lens_sigma_px);
    EpipolarSolution solution;
    solution.weights.assign(samples_.size(), 1.0);
    solution.error_px = 1.0;
    double last_step_sigmas = 0.0;
    for (int step = 0; step < kNumSteps; ++step) {
        const NormalEquations normal = equations(solution, held, prior);
        const EpipolarUnknowns change = -normal.information.ldlt().solve(normal.gradient);
        last_step_sigmas = step_sigmas(change, normal.information, held);
        solution.values += change;
        const std::vector<double> errors = errors_px(solution.values);
        solution.error_px = robust_sigma(errors);
        if (step < kNumPlainSteps) continue;
        std::ranges::transform(errors, solution.weights.begin(), [&](double error) {
            return stats::tukey_weight(error, stats::kTukey * solution.error_px);
        });
    }
    const optimisation::IrlsSteps steps{
        .num_steps = kNumSteps,
        .initial_cost = cost(EpipolarUnknowns::Zero(), solution.error_px, prior),
        .final_cost = cost(solution.values, solution.error_px, prior),
        .last_step_sigmas = last_step_sigmas};
    const NormalEquations last = equations(solution, held, prior);
    const EpipolarCovariance inverse = last.information.inverse();
    solution.covariance = inverse + inverse * last.between_pairs * inverse;
    for (int k = 0; k < kNumEpipolarUnknowns; ++k) {
        if (!held[static_cast<std::size_t>(k)]) continue;
        solution.covariance.row(k).setZero();
        solution.covariance.col(k).setZero();
    }
    return {std::move(solution), last.information, steps};
}

}  // namespace divemesh::calibration
