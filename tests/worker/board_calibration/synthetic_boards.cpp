#include "tests/worker/board_calibration/synthetic_boards.hpp"

#include <Eigen/Geometry>
#include <cmath>

#include "worker/base/rotation_vector.hpp"
#include "worker/camera/projection.hpp"
#include "worker/markers/tag_layout.hpp"

namespace divemesh::board_calibration {
namespace {

constexpr int kNumRays = 4;        // a side of a pixel
constexpr double kGround = 150.0;  // brightness around the board
constexpr double kBlack = 30.0;
constexpr double kWhite = 220.0;

double uniform(std::mt19937_64& random, double from, double to) {
    return std::uniform_real_distribution<double>(from, to)(random);
}

boards::BoardCorners seen_corners(const types::Camera& camera,
                                  const boards::Board& board,
                                  const Eigen::Isometry3d& T_cam_board,
                                  double sigma_px,
                                  std::mt19937_64& random) {
    std::normal_distribution<double> error(0.0, sigma_px);
    boards::BoardCorners corners;
    for (int i = 0; i < board.num_corners(); ++i) {
        const auto pixel = camera::project(camera, T_cam_board * board.corner_m(i));
        if (!pixel || !camera::contains(camera, *pixel)) return {};
        corners.push_back({i, *pixel + Eigen::Vector2d(error(random), error(random))});
    }
    return corners;
}

double checkerboard_brightness(const boards::Board& board, const Eigen::Vector2d& p_m) {
    const double column = p_m.x() / board.column_step_m + 1.0;  // of squares, with the outer ones
    const double row = p_m.y() / board.row_step_m + 1.0;
    if (column < -0.5 || row < -0.5 || column > board.num_columns + 1.5 ||
        row > board.num_rows + 1.5)
        return kGround;
    if (column < 0.0 || row < 0.0 || column > board.num_columns + 1 || row > board.num_rows + 1)
        return kWhite;
    const int sum = static_cast<int>(std::floor(column)) + static_cast<int>(std::floor(row));
    return sum % 2 == 0 ? kBlack : kWhite;
}

// Kalibr's grid: tags from the lower left one on, black squares where the corners of four meet.
double april_grid_brightness(const boards::Board& board,
                             const std::vector<cv::Mat>& tags,
                             const Eigen::Vector2d& p_m) {
    const double step_m = board.column_step_m;
    const double gap_m = step_m - board.tag_size_m;
    if (p_m.x() < -2.0 * gap_m || p_m.y() < -2.0 * gap_m ||
        p_m.x() > board.num_columns * step_m + gap_m || p_m.y() > board.num_rows * step_m + gap_m)
        return kGround;
    const int column = static_cast<int>(std::floor((p_m.x() + gap_m) / step_m));
    const int row = static_cast<int>(std::floor((p_m.y() + gap_m) / step_m));
    const double x_m = p_m.x() - column * step_m;  // from the corner of the tag; negative: gap
    const double y_m = p_m.y() - row * step_m;
    if (column < 0 || row < 0 || column > board.num_columns || row > board.num_rows) return kWhite;
    if (x_m < 0.0 || y_m < 0.0) return x_m < 0.0 && y_m < 0.0 ? kBlack : kWhite;
    if (column >= board.num_columns || row >= board.num_rows) return kWhite;
    // A border of two black cells: the family's tag without its white rim and one more black cell.
    const cv::Mat& tag = tags[static_cast<std::size_t>(row * board.num_columns + column)];
    const int u = static_cast<int>(x_m / (0.1 * board.tag_size_m));
    const int v = 9 - static_cast<int>(y_m / (0.1 * board.tag_size_m));
    if (std::min(u, v) < 1 || std::max(u, v) > 8) return kBlack;
    return tag.at<std::uint8_t>(v, u) == 0 ? kBlack : kWhite;
}

std::vector<cv::Mat> tags_of(const boards::Board& board) {
    std::vector<cv::Mat> tags;
    if (board.kind == boards::BoardKind::AprilGrid)
        for (int id = 0; id < board.num_columns * board.num_rows; ++id)
            tags.push_back(markers::tag_image(dive::MarkerFamily::Tag36h11, id));
    return tags;
}

}  // namespace

boards::Board known_checkerboard() {
    boards::Board board;
    board.num_columns = 9;
    board.num_rows = 7;
    board.column_step_m = board.row_step_m = 0.04;
    return board;
}

RigParameters known_rig(types::Distortion distortion) {
    RigParameters rig;
    rig.kind0 = rig.kind1 = {1280, 960, distortion};
    if (distortion == types::Distortion::Equidistant) {
        rig.lens0 = {520.0, 521.0, 645.0, 473.0, 0.02, -0.012, 0.006, -0.002};
        rig.lens1 = {525.0, 524.0, 633.0, 484.0, 0.018, -0.01, 0.005, -0.0015};
    } else if (distortion == types::Distortion::Rational) {
        rig.lens0 = {1010.0, 1012.0, 645.0, 473.0, 0.25, 0.03, 6e-4, -4e-4, 2e-3, 0.37, 0.06, 3e-3};
        rig.lens1 = {1004.0, 1003.0, 633.0, 484.0, 0.23, 0.04, -3e-4, 5e-4, 1e-3, 0.36, 0.07, 2e-3};
    } else if (distortion == types::Distortion::Omnidirectional) {
        rig.lens0 = {520.0, 521.0, 645.0, 473.0, 1.3, -0.05, 0.02, 6e-4, -4e-4};
        rig.lens1 = {525.0, 524.0, 633.0, 484.0, 1.25, -0.04, 0.01, -3e-4, 5e-4};
    } else if (distortion == types::Distortion::DoubleSphere) {
        rig.lens0 = {520.0, 521.0, 645.0, 473.0, -0.2, 0.57};
        rig.lens1 = {525.0, 524.0, 633.0, 484.0, -0.18, 0.58};
    } else if (distortion == types::Distortion::ExtendedUnified) {
        rig.lens0 = {520.0, 521.0, 645.0, 473.0, 0.61, 1.1};
        rig.lens1 = {525.0, 524.0, 633.0, 484.0, 0.6, 1.12};
    } else {
        rig.lens0 = {1010.0, 1012.0, 645.0, 473.0, -0.21, 0.08, 0.0006, -0.0004};
        rig.lens1 = {1004.0, 1003.0, 633.0, 484.0, -0.2, 0.07, -0.0003, 0.0005};
    }
    rig.T_cam1_cam0 = {0.004, -0.02, 0.006, -0.15, 0.001, -0.002};
    return rig;
}

std::vector<Eigen::Isometry3d> drawn_poses(const boards::Board& board,
                                           std::size_t num,
                                           std::mt19937_64& random) {
    std::vector<Eigen::Isometry3d> poses;
    for (std::size_t i = 0; i < num; ++i) {
        const double range_m = uniform(random, 0.5, 2.0);
        const Eigen::Vector3d center(
            uniform(random, -0.5, 0.6) * range_m, uniform(random, -0.4, 0.4) * range_m, range_m);
        const Eigen::Vector3d tilt(
            uniform(random, -0.7, 0.7), uniform(random, -0.7, 0.7), uniform(random, -0.5, 0.5));
        Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
        T.linear() = base::rotation_from_vector(tilt).toRotationMatrix();
        if (board.kind == boards::BoardKind::AprilGrid)  // its y points up
            T.linear() = T.linear() * Eigen::Vector3d(1.0, -1.0, -1.0).asDiagonal();
        T.translation() = center - T.linear() * board.center_m();
        poses.push_back(T);
    }
    return poses;
}

std::vector<boards::BoardView> drawn_views(const RigParameters& rig,
                                           const boards::Board& board,
                                           const std::vector<Eigen::Isometry3d>& T_cam0_board,
                                           double sigma_px,
                                           std::mt19937_64& random) {
    std::vector<boards::BoardView> views;
    for (const Eigen::Isometry3d& T : T_cam0_board) {
        boards::BoardView view;
        view.timestamp_ns = 1'000'000'000 + 100'000'000 * std::ssize(views);
        view.left = seen_corners(rig.cam0(), board, T, sigma_px, random);
        view.right =
            seen_corners(rig.cam1(), board, isometry_of(rig.T_cam1_cam0) * T, sigma_px, random);
        if (!view.left.empty() || !view.right.empty()) views.push_back(std::move(view));
    }
    return views;
}

std::vector<Eigen::Vector3d> rays_over(const types::Camera& camera) {
    std::vector<Eigen::Vector3d> rays;
    for (int v = camera.height_px / 10; v < camera.height_px; v += camera.height_px / 5)
        for (int u = camera.width_px / 10; u < camera.width_px; u += camera.width_px / 5)
            rays.push_back(camera::unproject(camera, Eigen::Vector2d(u, v)));
    return rays;
}

ImageRays::ImageRays(const types::Camera& camera) : width_px_(camera.width_px) {
    for (int v = 0; v <= camera.height_px; ++v)
        for (int u = 0; u <= camera.width_px; ++u)
            at_.push_back(camera::unproject(camera, {u - 0.5, v - 0.5}).hnormalized());
}

Eigen::Vector3d ImageRays::ray(double column, double row) const {
    const auto u = static_cast<std::size_t>(column);
    const auto v = static_cast<std::size_t>(row);
    const std::size_t line = static_cast<std::size_t>(width_px_) + 1;
    const Eigen::Vector2d* upper = &at_[v * line + u];
    const Eigen::Vector2d* lower = upper + line;
    const double right = column - static_cast<double>(u);
    const double down = row - static_cast<double>(v);
    const Eigen::Vector2d ray = (1.0 - down) * ((1.0 - right) * upper[0] + right * upper[1]) +
                                down * ((1.0 - right) * lower[0] + right * lower[1]);
    return ray.homogeneous();
}

cv::Mat rendered_board(const ImageRays& rays,
                       const boards::Board& board,
                       const Eigen::Isometry3d& T_cam_board) {
    const std::vector<cv::Mat> tags = tags_of(board);
    cv::Mat image(rays.height_px(), rays.width_px(), CV_8UC1);
    const Eigen::Isometry3d T_board_cam = T_cam_board.inverse();
    const Eigen::Vector3d eye = T_board_cam.translation();
    for (int v = 0; v < image.rows; ++v)
        for (int u = 0; u < image.cols; ++u) {
            double sum = 0.0;
            for (int k = 0; k < kNumRays * kNumRays; ++k) {
                const Eigen::Vector3d ray =
                    T_board_cam.linear() * rays.ray(u + (k % kNumRays + 0.5) / kNumRays,
                                                    v + (k / kNumRays + 0.5) / kNumRays);
                const double at = -eye.z() / ray.z();
                const Eigen::Vector2d p_m = (eye + at * ray).head<2>();
                if (!(at > 0.0))
                    sum += kGround;
                else
                    sum += board.kind == boards::BoardKind::Checkerboard
                               ? checkerboard_brightness(board, p_m)
                               : april_grid_brightness(board, tags, p_m);
            }
            image.at<std::uint8_t>(v, u) =
                static_cast<std::uint8_t>(std::lround(sum / (kNumRays * kNumRays)));
        }
    return image;
}

}  // namespace divemesh::board_calibration
