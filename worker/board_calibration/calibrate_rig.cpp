#include "worker/board_calibration/calibrate_rig.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "worker/base/rotation_vector.hpp"
#include "worker/base/text.hpp"
#include "worker/camera/lens_model.hpp"
#include "worker/stats/median.hpp"

namespace divemesh::board_calibration {
namespace {

constexpr double kFirstHuber_px = 1.0;
constexpr double kHarmfulRatio = 3.0;  // of a view's errors to those of the others
constexpr double kMinHarm_px = 0.3;    // smaller errors of a view do no harm
constexpr double kMaxCornerSigmas = 6.0;
constexpr double kAtLimit = 1e-6;  // of a coefficient's range
constexpr int kMaxRounds = 3;      // in which views are left out
constexpr std::size_t kMinCommonViews = 3;

struct LensPair {
    LensEstimate left;
    LensEstimate right;

    ModelFit fit() const { return {left.kind.distortion, left.rms_px, right.rms_px}; }
    double sum_px2() const { return left.rms_px * left.rms_px + right.rms_px * right.rms_px; }
};

std::optional<LensPair> estimate_lenses(const boards::Board& board,
                                        const std::vector<boards::BoardView>& views,
                                        cv::Size left_size,
                                        cv::Size right_size,
                                        types::Distortion distortion) {
    std::vector<boards::BoardCorners> left;
    std::vector<boards::BoardCorners> right;
    for (const boards::BoardView& view : views) {
        left.push_back(view.left);
        right.push_back(view.right);
    }
    auto of_left = estimate_lens(board, left, {left_size.width, left_size.height, distortion});
    auto of_right = estimate_lens(board, right, {right_size.width, right_size.height, distortion});
    if (!of_left || !of_right) return std::nullopt;
    return LensPair{std::move(*of_left), std::move(*of_right)};
}

// Returns the relative pose that is nearest to those of all other views which both cameras see.
std::optional<Eigen::Isometry3d> initial_T_cam1_cam0(const LensPair& lenses) {
    std::vector<Eigen::Isometry3d> all;
    for (std::size_t i = 0; i < lenses.left.T_cam_board.size(); ++i) {
        const auto& left = lenses.left.T_cam_board[i];
        const auto& right = lenses.right.T_cam_board[i];
        if (left && right) all.push_back(isometry_of(*right) * isometry_of(*left).inverse());
    }
    if (all.size() < kMinCommonViews) return std::nullopt;
    std::size_t best = 0;
    double least = std::numeric_limits<double>::max();
    for (std::size_t i = 0; i < all.size(); ++i) {
        double sum = 0.0;
        for (const Eigen::Isometry3d& other : all)
            sum += (all[i].translation() - other.translation()).norm() +
                   base::angle_rad(all[i].linear().transpose() * other.linear());
        if (sum < least) {
            least = sum;
            best = i;
        }
    }
    return all[best];
}

// Returns the views with the pose that either camera found; corners of a camera that found none
// are left out.
std::vector<PosedView> posed_views(const std::vector<boards::BoardView>& views,
                                   const LensPair& lenses,
                                   const Eigen::Isometry3d& T_cam1_cam0) {
    std::vector<PosedView> posed;
    for (std::size_t i = 0; i < views.size(); ++i) {
        const auto& left = lenses.left.T_cam_board[i];
        const auto& right = lenses.right.T_cam_board[i];
        if (!left && !right) continue;
        PosedView view{views[i],
                       left ? *left : values_of(T_cam1_cam0.inverse() * isometry_of(*right))};
        if (!left) view.view.left.clear();
        if (!right) view.view.right.clear();
        posed.push_back(std::move(view));
    }
    return posed;
}

std::vector<double> rms_of_views(const std::vector<CornerError>& errors, std::size_t num_views) {
    std::vector<double> squares(num_views, 0.0);
    std::vector<double> nums(num_views, 0.0);
    for (const CornerError& error : errors) {
        squares[error.view] += error.error_px.squaredNorm();
        nums[error.view] += 2.0;
    }
    for (std::size_t i = 0; i < num_views; ++i)
        squares[i] = std::sqrt(squares[i] / std::max(1.0, nums[i]));
    return squares;
}

// Removes views whose errors are far larger than those of the others. Returns whether there were
// some.
bool leave_out_views(const boards::Board& board, RigEstimate& estimate) {
    const std::vector<double> rms =
        rms_of_views(corner_errors(board, estimate.rig, estimate.views), estimate.views.size());
    const double median_px = stats::median(rms);
    const double limit_px = std::max(kMinHarm_px, kHarmfulRatio * median_px);
    std::vector<PosedView> kept;
    for (std::size_t i = 0; i < rms.size(); ++i) {
        if (rms[i] <= limit_px)
            kept.push_back(std::move(estimate.views[i]));
        else
            estimate.left_out.push_back({estimate.views[i].view.timestamp_ns, rms[i], median_px});
    }
    const bool has_left_out = kept.size() < rms.size();
    estimate.views = std::move(kept);
    return has_left_out;
}

void leave_out_corners(const boards::Board& board, RigEstimate& estimate) {
    const auto errors = corner_errors(board, estimate.rig, estimate.views);
    const double limit_px = kMaxCornerSigmas * noise_px(errors);
    for (const CornerError& error : errors) {
        if (error.error_px.norm() <= limit_px) continue;
        boards::BoardView& view = estimate.views[error.view].view;
        std::erase_if(
            error.is_right ? view.right : view.left,
            [&](const boards::BoardCorner& corner) { return corner.corner == error.corner; });
        ++estimate.num_corners_left_out;
    }
}

std::size_t num_common(const std::vector<PosedView>& views) {
    return static_cast<std::size_t>(
        std::count_if(views.begin(), views.end(), [](const PosedView& posed) {
            return !posed.view.left.empty() && !posed.view.right.empty();
        }));
}

// Returns the standard deviation of one axis, corrected for the number of parameters.
double sigma_of(const RigEstimate& estimate) {
    double squares = 0.0;
    for (const CornerError& error : estimate.errors) squares += error.error_px.squaredNorm();
    const double num_free = 2.0 * static_cast<double>(estimate.errors.size()) -
                            estimate.rig.size() -
                            kPoseSize * static_cast<double>(estimate.views.size());
    return num_free > 0.0 ? std::sqrt(squares / num_free) : 0.0;
}

// Returns what ends at a limit of its range: "alpha of cam1 ends at 0"; "" if there is none.
std::string coefficient_at_limit(const RigParameters& rig) {
    for (const bool is_right : {false, true}) {
        const types::Camera camera = is_right ? rig.cam1() : rig.cam0();
        auto value = camera.distortion_coefficients.begin();
        for (const auto& coefficient : camera::lens_model(camera.distortion).leading) {
            const double tolerance = kAtLimit * (coefficient.max - coefficient.min);
            for (const double limit : {coefficient.min, coefficient.max})
                if (std::abs(*value - limit) <= tolerance)
                    return std::string(coefficient.name) + " of " + (is_right ? "cam1" : "cam0") +
                           " ends at " + base::significant(limit);
            ++value;
        }
    }
    return "";
}

// Solves for everything, without what harms; sets `failure` if that fails.
void solve(const boards::Board& board, const base::ProgressShare& progress, RigEstimate& estimate) {
    const char* kTooFew =
        "fewer than 3 pairs in which both cameras see the board fit together: hold the board "
        "still in 20 or more places where both cameras see it, and trigger both cameras together";
    SolveOutcome outcome = solve_rig(board, kFirstHuber_px, estimate.rig, estimate.views);
    for (int round = 0; round < kMaxRounds && leave_out_views(board, estimate); ++round) {
        if (num_common(estimate.views) < kMinCommonViews) {
            estimate.failure = kTooFew;
            return;
        }
        progress.at(0.6 + 0.1 * round);
        outcome = solve_rig(board, kFirstHuber_px, estimate.rig, estimate.views);
    }
    leave_out_corners(board, estimate);
    std::erase_if(estimate.views, [](const PosedView& posed) {
        return posed.view.left.size() + posed.view.right.size() < 4;
    });
    if (num_common(estimate.views) < kMinCommonViews) {
        estimate.failure = kTooFew;
        return;
    }
    const double huber_px =
        kHuberSigmas * noise_px(corner_errors(board, estimate.rig, estimate.views));
    outcome = solve_rig(board, std::max(1e-6, huber_px), estimate.rig, estimate.views);
    estimate.errors = corner_errors(board, estimate.rig, estimate.views);
    estimate.sigma_px = sigma_of(estimate);
    const auto covariance = rig_covariance(board, estimate.sigma_px, estimate.rig, estimate.views);
    if (covariance) estimate.covariance = *covariance;
    const std::string at_limit = coefficient_at_limit(estimate.rig);
    if (!at_limit.empty())
        estimate.failure = "the lens model does not fit: " + at_limit +
                           ", the limit of its range; try --model with another lens model";
    else if (!outcome.converged)
        estimate.failure = "the solver did not converge (" + outcome.message +
                           "): hold the board in more places and tilts";
    else if (!covariance)
        estimate.failure =
            "the pairs do not determine the lenses: hold the board tilted, at other distances and "
            "in all corners of both images";
}

std::vector<types::Distortion> models_to_try(std::optional<types::Distortion> model) {
    if (model) return {*model};
    return {types::Distortion::RadialTangential, types::Distortion::Equidistant};
}

}  // namespace

RigEstimate calibrate_rig(const boards::Board& board,
                          const std::vector<boards::BoardView>& views,
                          cv::Size left_size,
                          cv::Size right_size,
                          std::optional<types::Distortion> model,
                          const base::ProgressShare& progress) {
    RigEstimate estimate;
    std::optional<LensPair> best;
    for (const auto distortion : models_to_try(model)) {
        progress.at(estimate.models.empty() ? 0.0 : 0.3);
        auto lenses = estimate_lenses(board, views, left_size, right_size, distortion);
        if (!lenses) continue;
        estimate.models.push_back(lenses->fit());
        if (best && best->sum_px2() <= lenses->sum_px2()) continue;
        best = std::move(lenses);
        std::swap(estimate.models.front(), estimate.models.back());
    }
    const auto T_cam1_cam0 = best ? initial_T_cam1_cam0(*best) : std::nullopt;
    if (!T_cam1_cam0) {
        estimate.failure =
            "fewer than 3 pairs show the board to both cameras: hold the board still in 20 or more "
            "places where both cameras see it, and check the counts in the target file";
        return estimate;
    }
    progress.at(0.5);
    estimate.rig = {best->left.kind,
                    best->right.kind,
                    best->left.values,
                    best->right.values,
                    values_of(*T_cam1_cam0)};
    estimate.views = posed_views(views, *best, *T_cam1_cam0);
    solve(board, progress, estimate);
    progress.at(1.0);
    return estimate;
}

}  // namespace divemesh::board_calibration
