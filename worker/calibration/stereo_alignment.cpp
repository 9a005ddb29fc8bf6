#include "worker/calibration/stereo_alignment.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <set>

#include "worker/base/rotation_vector.hpp"
#include "worker/calibration/epipolar_problem.hpp"
#include "worker/calibration/row_consensus.hpp"
#include "worker/camera/rectified_lens.hpp"

namespace divemesh::calibration {
namespace {

constexpr std::size_t kMinMatches = 150;
constexpr std::size_t kMinInliers = 80;
constexpr double kMinInlierShare = 0.5;
constexpr double kSignificant = 4.0;  // sigmas
// Tracking does not notice less than this. A roll that is left tilts the ranges of all points: at
// 0.25 px it changed the scale by 2 %.
constexpr double kMinRowShift_px = 0.1;
// Calibrations are off by more than this more often than not, so three sigmas convince.
constexpr double kMinBias_px = 0.3;
constexpr double kSignificantBias = 3.0;
// How far a yaw, a principal point and the lenses may be off before ranges are compared.
constexpr double kYawSigma_rad = 0.0175;
constexpr double kCentreSigma_px = 1.0;
constexpr double kK1Sigma = 0.01;
// Lenses as calibrations leave them may look like a shift by a pixel.
constexpr double kMinShift_px = 1.5;
constexpr double kMinShiftedShare = 0.5;  // of what the change does to the rows
constexpr int kMinInliersOfPair = 8;
// Rows of pairs that differ by more than this share of the focal length fit no fixed rig.
constexpr double kMaxPairError_rad = 1e-3;

using Change = types::RigChange;
// Held at the stated value unless significant; rows alone never tell a yaw from lens errors.
constexpr std::array<int, 5> kOptional = {
    Change::kPitch, Change::kRoll, Change::kDown, Change::kForward, Change::kFocal};

bool is_held(const EpipolarProblem::Held& held, int index) {
    return held[static_cast<std::size_t>(index)];
}

double sigmas_off(const EpipolarSolution& solution, int index) {
    return std::abs(solution.values[index]) / std::sqrt(solution.covariance(index, index));
}

// Solves with fewer and fewer optional unknowns until each is significant.
EpipolarSolution solve_significant(const EpipolarProblem& problem, EpipolarProblem::Held& held) {
    while (true) {
        EpipolarSolution solution = problem.solve(held);
        int least_significant = -1;
        for (const int index : kOptional)
            if (!is_held(held, index) &&
                (least_significant < 0 ||
                 sigmas_off(solution, index) < sigmas_off(solution, least_significant)))
                least_significant = index;
        if (least_significant < 0 || sigmas_off(solution, least_significant) > kSignificant)
            return solution;
        held[static_cast<std::size_t>(least_significant)] = true;
    }
}

// Returns the RMS over the inliers of what the change does to their rows.
double row_shift_px(const EpipolarProblem& problem, const EpipolarSolution& solution) {
    EpipolarUnknowns changed = solution.values;
    changed.tail<kNumLensTerms>().setZero();  // lenses are not changed
    const std::vector<double> before = problem.errors_px(EpipolarUnknowns::Zero());
    const std::vector<double> after = problem.errors_px(changed);
    double squares = 0.0;
    double sum = 0.0;
    for (std::size_t i = 0; i < before.size(); ++i) {
        squares += solution.weights[i] * (after[i] - before[i]) * (after[i] - before[i]);
        sum += solution.weights[i];
    }
    return sum > 0.0 ? std::sqrt(squares / sum) : 0.0;
}

// Returns the solution with the principal point in place of most of the pitch, if rows tell it: an
// image that is shifted, as by a crop, moves all rows alike, and a rotation moves those at the
// borders further.
std::optional<EpipolarSolution> solve_shifted(const EpipolarProblem& problem) {
    EpipolarProblem::Held held{};
    held[Change::kYaw] = held[Change::kCentre] = true;
    const EpipolarSolution solution = solve_significant(problem, held);
    const double shift_px = std::abs(solution.values[Change::kCentreDown]);
    if (shift_px < kMinShift_px || shift_px < kMinShiftedShare * row_shift_px(problem, solution) ||
        sigmas_off(solution, Change::kCentreDown) < kSignificant)
        return std::nullopt;
    return solution;
}

// Returns the RMS over the pairs of the mean error of a pair.
double pair_error_px(const types::StereoMatches& matches,
                     const std::vector<double>& errors_px,
                     const std::vector<double>& weights) {
    double squares = 0.0;
    int num_pairs = 0;
    for (std::size_t begin = 0, end = 0; begin < matches.size(); begin = end) {
        double sum_px = 0.0;
        double weight = 0.0;
        for (; end < matches.size() && matches[end].frame_index == matches[begin].frame_index;
             ++end) {
            sum_px += weights[end] * errors_px[end];
            weight += weights[end];
        }
        if (weight < kMinInliersOfPair) continue;
        squares += sum_px * sum_px / (weight * weight);
        ++num_pairs;
    }
    return num_pairs > 0 ? std::sqrt(squares / num_pairs) : 0.0;
}

std::int32_t num_pairs(const types::StereoMatches& matches) {
    std::set<int> frames;
    for (const types::StereoMatch& match : matches) frames.insert(match.frame_index);
    return static_cast<std::int32_t>(frames.size());
}

std::int32_t num_inliers(const EpipolarSolution& solution) {
    return static_cast<std::int32_t>(
        std::ranges::count_if(solution.weights, [](double weight) { return weight > 0.0; }));
}

bool rows_significant(const EpipolarSolution& solution) {
    const auto is_told = [&](int index) {
        return solution.values[index] != 0.0 && sigmas_off(solution, index) > kSignificant;
    };
    return is_told(Change::kPitch) || is_told(Change::kRoll) || is_told(Change::kCentreDown);
}

types::RigAlignment::Outcome judge(const types::RigAlignment& found,
                                   const EpipolarSolution& solution,
                                   double focal_px) {
    using Outcome = types::RigAlignment::Outcome;
    if (solution.outcome.failed() || found.num_inliers < kMinInlierShare * found.num_matches ||
        found.pair_error_px > kMaxPairError_rad * focal_px)
        return Outcome::Inconsistent;
    const bool rows_moved = found.row_shift_px >= kMinRowShift_px && rows_significant(solution);
    return rows_moved ? Outcome::Moved : Outcome::AsStated;
}

}  // namespace

types::RigAlignment estimate_rig_alignment(const types::Rig& rig,
                                           const types::RectifiedRig& rectified,
                                           const types::StereoMatches& matches) {
    types::RigAlignment result;
    result.num_pairs = num_pairs(matches);
    result.num_matches = static_cast<std::int32_t>(matches.size());
    if (matches.size() < kMinMatches) return result;
    const types::StereoMatches agreeing = agreeing_rows(rectified, matches);
    if (agreeing.size() < kMinInliers) {
        result.outcome = types::RigAlignment::Outcome::Inconsistent;
        return result;
    }
    const EpipolarProblem problem(rig, rectified, agreeing);
    EpipolarProblem::Held held{};
    held[Change::kYaw] = held[Change::kCentre] = held[Change::kCentreDown] = true;
    EpipolarSolution solution = solve_significant(problem, held);
    if (row_shift_px(problem, solution) > kMinShift_px)
        if (const auto shifted = solve_shifted(problem)) solution = *shifted;
    result.num_inliers = num_inliers(solution);
    result.change.values = solution.values.head<types::RigChange::kSize>();
    result.sigmas = solution.covariance.diagonal().head<types::RigChange::kSize>().cwiseSqrt();
    result.row_shift_px = row_shift_px(problem, solution);
    result.row_error_px = solution.error_px;
    result.row_solver.add(solution.outcome);
    result.pair_error_px =
        pair_error_px(agreeing, problem.errors_px(solution.values), solution.weights);
    result.outcome = judge(result, solution, rectified.focal_px);
    return result;
}

types::RigPart estimate_turn(const types::Rig& rig,
                             const types::RectifiedRig& rectified,
                             const types::StereoMatches& matches) {
    types::RigPart part;
    if (matches.size() < kMinMatches) return part;
    const types::StereoMatches agreeing = agreeing_rows(rectified, matches);
    if (agreeing.size() < kMinInliers) return part;
    const EpipolarProblem problem(rig, rectified, agreeing);
    EpipolarProblem::Held held{};
    for (const int index :
         {Change::kYaw, Change::kCentre, Change::kCentreDown, Change::kDown, Change::kForward})
        held[static_cast<std::size_t>(index)] = true;
    const EpipolarSolution solution = solve_significant(problem, held);
    part.found = !solution.outcome.failed() &&
                 num_inliers(solution) >= kMinInlierShare * static_cast<double>(matches.size());
    if (!part.found) return part;
    part.values = solution.values.head<types::RigChange::kSize>();
    part.sigmas = solution.covariance.diagonal().head<types::RigChange::kSize>().cwiseSqrt();
    part.shift_px = row_shift_px(problem, solution);
    return part;
}

void add_yaw(const types::Rig& rig, double yaw_rad, Change::Vector& change) {
    const Eigen::Matrix3d R_cam1_rectified = camera::rectified_lenses(rig)[1].R_camera_rectified;
    const Eigen::Quaterniond turned =
        base::rotation_from_vector(change.head<3>()) *
        base::rotation_from_vector(R_cam1_rectified * (yaw_rad * Eigen::Vector3d::UnitY()));
    change.head<3>() = base::vector_from_rotation(turned);
}

RangeUnknowns expected_ranges() { return RangeUnknowns::Zero(); }

RangeUnknowns expected_range_sigmas() {
    return {kYawSigma_rad, kCentreSigma_px, kK1Sigma, kK1Sigma};
}

void add_ranges(const types::Rig& rig,
                const types::RectifiedRig& rectified,
                const RangeSolution& ranges,
                types::RigAlignment& alignment) {
    alignment.num_windows = ranges.num_windows;
    if (ranges.num_windows == 0) return;
    alignment.range_solver.add(ranges.outcome);
    if (ranges.outcome.failed()) return;
    alignment.disparity_bias_px = ranges.bias_px;
    alignment.disparity_bias_sigma_px = ranges.bias_sigma_px;
    if (std::abs(ranges.bias_px) < std::max(kMinBias_px, kSignificantBias * ranges.bias_sigma_px))
        return;
    Change::Vector& change = alignment.change.values;
    add_yaw(changed_rig(rig, alignment.change), ranges.values[0], change);
    const double recorded_by_rectified =
        rig.cam1.refractive_index * rig.cam1.fx_px / rectified.focal_px;
    change[Change::kCentre] = ranges.values[1] * recorded_by_rectified;
    alignment.sigmas[Change::kYaw] = std::sqrt(ranges.covariance(0, 0));
    alignment.sigmas[Change::kCentre] = std::sqrt(ranges.covariance(1, 1)) * recorded_by_rectified;
    alignment.outcome = types::RigAlignment::Outcome::Moved;
}

types::Rig rig_in_medium(const types::Rig& rig, const types::MediumChange& medium) {
    types::Rig result = rig;
    for (types::Camera* camera : {&result.cam0, &result.cam1}) {
        camera->fx_px *= medium.focal_scale;
        camera->fy_px *= medium.focal_scale;
        camera->refractive_index *= medium.refractive_index;
    }
    return result;
}

types::Rig changed_rig(const types::Rig& rig, const types::RigChange& change) {
    const Eigen::Isometry3d T_cam0_cam1 = rig.T_cam1_cam0().inverse();
    const Eigen::Matrix3d R_cam0_rectified = camera::rectified_lenses(rig)[0].R_camera_rectified;
    const Eigen::Vector3d direction(
        1.0, change.values[Change::kDown], change.values[Change::kForward]);
    Eigen::Isometry3d T_cam0_moved = Eigen::Isometry3d::Identity();
    T_cam0_moved.linear() = T_cam0_cam1.linear() *
                            base::rotation_from_vector(change.values.head<3>()).toRotationMatrix();
    T_cam0_moved.translation() =
        T_cam0_cam1.translation().norm() * (R_cam0_rectified * direction.normalized());
    types::Rig result = rig_in_medium(rig, change.medium);
    result.T_imu_cam1 = rig.T_imu_cam0 * T_cam0_moved;
    result.cam1.fx_px *= 1.0 + change.values[Change::kFocal];
    result.cam1.fy_px *= 1.0 + change.values[Change::kFocal];
    result.cam1.cx_px += change.values[Change::kCentre];
    result.cam1.cy_px += change.values[Change::kCentreDown];
    return result;
}

}  // namespace divemesh::calibration
