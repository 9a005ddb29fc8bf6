#include "worker/board_calibration/board_shape.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <map>

#include "worker/base/horn.hpp"
#include "worker/base/nearest_to_rays.hpp"
#include "worker/camera/projection.hpp"

namespace divemesh::board_calibration {
namespace {

constexpr std::size_t kMinCommonCorners = 8;
constexpr double kMinParallax = 1e-12;

using Corners = std::map<int, Eigen::Vector3d>;  // position by corner, m

Corners triangulated(const types::Camera& cam0,
                     const types::Camera& cam1,
                     const Eigen::Isometry3d& T_cam0_cam1,
                     const boards::BoardView& view) {
    std::map<int, Eigen::Vector2d> right;
    for (const boards::BoardCorner& corner : view.right) right[corner.corner] = corner.pixel;
    Corners corners;
    for (const boards::BoardCorner& corner : view.left) {
        const auto partner = right.find(corner.corner);
        if (partner == right.end()) continue;
        const auto p_cam0 = base::nearest_to_rays(
            {{Eigen::Vector3d::Zero(), camera::unproject(cam0, corner.pixel)},
             {T_cam0_cam1.translation(),
              T_cam0_cam1.linear() * camera::unproject(cam1, partner->second)}},
            kMinParallax);
        if (p_cam0) corners[corner.corner] = *p_cam0;
    }
    return corners;
}

// Returns the corners in the frame of the board; {} if they do not determine it.
Corners on_board(const boards::Board& board, const Corners& corners_cam0) {
    std::vector<Eigen::Vector3d> seen;
    std::vector<Eigen::Vector3d> stated;
    for (const auto& [corner, p_cam0] : corners_cam0) {
        seen.push_back(p_cam0);
        stated.push_back(board.corner_m(corner));
    }
    const auto fit = base::absolute_orientation(seen, stated);
    Corners corners;
    if (!fit) return corners;
    for (const auto& [corner, p_cam0] : corners_cam0) corners[corner] = fit->T_b_a * p_cam0;
    return corners;
}

void measure_flatness(const Corners& corners, BoardShape& shape) {
    Eigen::Vector3d mean = Eigen::Vector3d::Zero();
    for (const auto& [corner, p] : corners) mean += p;
    mean /= static_cast<double>(corners.size());
    Eigen::Matrix3d squares = Eigen::Matrix3d::Zero();
    for (const auto& [corner, p] : corners) squares += (p - mean) * (p - mean).transpose();
    const Eigen::Vector3d normal =
        Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(squares).eigenvectors().col(0);
    double sum_m2 = 0.0;
    for (const auto& [corner, p] : corners) {
        const double off_m = std::abs(normal.dot(p - mean));
        shape.flatness_max_m = std::max(shape.flatness_max_m, off_m);
        sum_m2 += off_m * off_m;
    }
    shape.flatness_rms_m = std::sqrt(sum_m2 / static_cast<double>(corners.size()));
}

void measure_steps(const boards::Board& board, const Corners& corners, BoardShape& shape) {
    std::vector<double> errors;
    const int columns = board.num_corner_columns();
    for (const auto& [corner, p] : corners)
        for (const int next : {corner + 1, corner + columns}) {
            if (next == corner + 1 && next % columns == 0) continue;
            const auto neighbour = corners.find(next);
            if (neighbour == corners.end()) continue;
            const double stated_m = (board.corner_m(next) - board.corner_m(corner)).norm();
            errors.push_back((neighbour->second - p).norm() / stated_m - 1.0);
        }
    const auto num = static_cast<double>(std::max<std::size_t>(1, errors.size()));
    for (const double error : errors) shape.step_error += error / num;
    double squares = 0.0;
    for (const double error : errors) squares += std::pow(error - shape.step_error, 2.0);
    shape.step_spread = std::sqrt(squares / num);
}

}  // namespace

std::optional<BoardShape> board_shape(const boards::Board& board,
                                      const types::Camera& cam0,
                                      const types::Camera& cam1,
                                      const Eigen::Isometry3d& T_cam1_cam0,
                                      const std::vector<boards::BoardView>& views) {
    Corners sums;
    std::map<int, int> nums;
    BoardShape shape;
    for (const boards::BoardView& view : views) {
        const Corners seen = triangulated(cam0, cam1, T_cam1_cam0.inverse(), view);
        if (seen.size() < kMinCommonCorners) continue;
        const Corners placed = on_board(board, seen);
        shape.num_views += placed.empty() ? 0 : 1;
        for (const auto& [corner, p_board] : placed) {
            sums.try_emplace(corner, Eigen::Vector3d::Zero()).first->second += p_board;
            ++nums[corner];
        }
    }
    if (sums.empty()) return std::nullopt;
    for (auto& [corner, sum] : sums) sum /= nums[corner];
    shape.num_corners = static_cast<int>(sums.size());
    measure_flatness(sums, shape);
    measure_steps(board, sums, shape);
    return shape;
}

}  // namespace divemesh::board_calibration
