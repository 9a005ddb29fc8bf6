#include "worker/board_calibration/lens_estimate.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "worker/board_calibration/board_pose.hpp"
#include "worker/camera/lens_model.hpp"
#include "worker/stats/median.hpp"

namespace divemesh::board_calibration {
namespace {

constexpr std::size_t kMinViews = 3;        // two lenses fit two views
constexpr std::size_t kMaxFocalViews = 24;  // to tell the focal length to a tenth
constexpr double kMinFocal = 0.2;           // of the width: a fisheye of 180 degrees has 0.32
constexpr double kMaxFocal = 4.0;           // of the width: a telephoto lens of 14 degrees
constexpr int kNumFocals = 24;
constexpr double kHuber_px = 1.0;
constexpr double kUnposed_px = 50.0;  // counts for a view that no pose explains
constexpr double kSigmasPerMedianLength = 0.849321800288019;  // 1 / sqrt(2 ln 2)
constexpr double kMaxSigmas = 5.0;
constexpr double kClearSigmas = 3.0;

LensValues starting_lens(const LensKind& kind, const types::LensCoefficients& k, double focal_px) {
    LensValues lens = {focal_px, focal_px, 0.5 * (kind.width_px - 1), 0.5 * (kind.height_px - 1)};
    std::copy(k.begin(), k.end(), lens.begin() + kPinholeSize);
    return lens;
}

// Returns the views by which focal lengths are compared: spread over the recording.
std::vector<boards::BoardCorners> some_of(const std::vector<boards::BoardCorners>& views) {
    std::vector<boards::BoardCorners> seen;
    for (const auto& view : views)
        if (view.size() >= kMinCorners) seen.push_back(view);
    if (seen.size() <= kMaxFocalViews) return seen;
    std::vector<boards::BoardCorners> some;
    for (std::size_t i = 0; i < kMaxFocalViews; ++i)
        some.push_back(seen[i * seen.size() / kMaxFocalViews]);
    return some;
}

LensValues initial_lens(const boards::Board& board,
                        const std::vector<boards::BoardCorners>& views,
                        const LensKind& kind,
                        const types::LensCoefficients& start) {
    const auto some = some_of(views);
    LensValues best = {};
    double least_px = std::numeric_limits<double>::max();
    for (int i = 0; i < kNumFocals; ++i) {
        const double share = kMinFocal * std::pow(kMaxFocal / kMinFocal, i / (kNumFocals - 1.0));
        const LensValues lens = starting_lens(kind, start, share * kind.width_px);
        double sum_px = 0.0;
        for (const auto& view : some) {
            const auto pose = find_board_pose(camera_of(kind, lens), board, view);
            sum_px += pose ? std::min(pose->rms_px, kUnposed_px) : kUnposed_px;
        }
        if (sum_px < least_px) {
            least_px = sum_px;
            best = lens;
        }
    }
    return best;
}

double capped_rms_px(const std::vector<CornerError>& errors) {
    const double cap_px = kMaxSigmas * noise_px(errors);
    double squares = 0.0;
    for (const CornerError& error : errors)
        squares += std::pow(std::min(error.error_px.norm(), cap_px), 2.0);
    return std::sqrt(squares /
                     (2.0 * static_cast<double>(std::max<std::size_t>(1, errors.size()))));
}

// Returns true if the sum of squares falls by more than noise lets it.
bool is_clearly_better(const LensEstimate& later, const LensEstimate& first) {
    const double squares_px2 = later.rms_px * later.rms_px;
    const double fall_px2 = first.rms_px * first.rms_px - squares_px2;
    return 2.0 * static_cast<double>(later.num_corners) * fall_px2 >
           kClearSigmas * kClearSigmas * squares_px2;
}

// Returns the estimate that least squares reach from one start; nullopt as estimate_lens().
std::optional<LensEstimate> estimate_from(const boards::Board& board,
                                          const std::vector<boards::BoardCorners>& views,
                                          const LensKind& kind,
                                          const types::LensCoefficients& start) {
    RigParameters rig;
    rig.kind0 = kind;
    rig.lens0 = initial_lens(board, views, kind, start);
    std::vector<PosedView> posed;
    std::vector<std::size_t> of_view;
    for (std::size_t i = 0; i < views.size(); ++i) {
        const auto pose = find_board_pose(rig.cam0(), board, views[i]);
        if (!pose) continue;
        posed.push_back({{.left = views[i]}, values_of(pose->T_cam_board)});
        of_view.push_back(i);
    }
    if (posed.size() < kMinViews) return std::nullopt;
    LensEstimate estimate;
    estimate.converged = solve_rig(board, kHuber_px, rig, posed).converged;
    estimate.kind = kind;
    estimate.values = rig.lens0;
    estimate.T_cam_board.resize(views.size());
    for (std::size_t k = 0; k < posed.size(); ++k)
        estimate.T_cam_board[of_view[k]] = posed[k].T_cam0_board;
    const auto errors = corner_errors(board, rig, posed);
    estimate.num_corners = errors.size();
    estimate.rms_px = capped_rms_px(errors);
    return estimate;
}

}  // namespace

double noise_px(const std::vector<CornerError>& errors) {
    std::vector<double> lengths;
    for (const CornerError& error : errors) lengths.push_back(error.error_px.norm());
    return kSigmasPerMedianLength * stats::median(std::move(lengths));
}

std::optional<LensEstimate> estimate_lens(const boards::Board& board,
                                          const std::vector<boards::BoardCorners>& views,
                                          const LensKind& kind) {
    std::optional<LensEstimate> best;
    for (const auto& start : camera::lens_model(kind.distortion).starts) {
        auto estimate = estimate_from(board, views, kind, start);
        if (estimate && (!best || is_clearly_better(*estimate, *best))) best = std::move(estimate);
    }
    return best;
}

}  // namespace divemesh::board_calibration
