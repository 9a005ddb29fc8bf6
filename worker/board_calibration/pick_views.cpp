#include "worker/board_calibration/pick_views.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>
#include <set>

#include "worker/board_calibration/board_pose.hpp"
#include "worker/board_calibration/rig_parameters.hpp"
#include "worker/board_calibration/view_coverage.hpp"

namespace divemesh::board_calibration {
namespace {

constexpr double kTiltBin_deg = 15.0;
constexpr double kDistanceBins = 3.0;  // when it doubles
constexpr double kPoseWeight = 6.0;    // of a new pose, in new cells

// What a view shows: cells of an image, or a pose.
struct Trait {
    std::array<int, 4> key;
    double weight = 1.0;

    bool operator<(const Trait& other) const { return key < other.key; }
};

void add_camera(const boards::Board& board,
                const boards::BoardCorners& corners,
                cv::Size size,
                int camera,
                std::set<Trait>& traits) {
    for (const boards::BoardCorner& corner : corners) {
        const CoverageCell cell = coverage_cell(corner.pixel, size);
        traits.insert({{camera, cell.column, cell.row, 0}, 1.0});
    }
    // The lens is not known yet: that of a camera of 53 degrees tells poses apart well enough.
    const double focal_px = size.width;
    const types::Camera rough =
        camera_of({size.width, size.height, types::Distortion::None},
                  {focal_px, focal_px, 0.5 * size.width, 0.5 * size.height});
    const auto pose = find_board_pose(rough, board, corners);
    if (!pose) return;
    const Eigen::Vector3d normal = pose->T_cam_board.linear().col(2);
    const double range_m = (pose->T_cam_board * board.center_m()).norm();
    const auto bin = [](double sine) {
        const double angle_deg = std::asin(std::clamp(sine, -1.0, 1.0)) * 180.0 / std::numbers::pi;
        return static_cast<int>(std::lround(angle_deg / kTiltBin_deg));
    };
    const int sign = normal.z() < 0.0 ? -1 : 1;
    traits.insert({{2 + camera, bin(sign * normal.x()), bin(sign * normal.y()), 0}, kPoseWeight});
    traits.insert(
        {{4 + camera, static_cast<int>(std::lround(kDistanceBins * std::log2(range_m))), 0, 0},
         kPoseWeight});
}

}  // namespace

std::vector<boards::BoardView> pick_views(const boards::Board& board,
                                          const std::vector<boards::BoardView>& views,
                                          cv::Size left_size,
                                          cv::Size right_size,
                                          std::size_t max_views) {
    if (views.size() <= max_views) return views;
    std::vector<std::set<Trait>> traits(views.size());
    for (std::size_t i = 0; i < views.size(); ++i) {
        add_camera(board, views[i].left, left_size, 0, traits[i]);
        add_camera(board, views[i].right, right_size, 1, traits[i]);
    }
    std::map<Trait, int> num_seen;
    std::set<std::size_t> picked;
    while (picked.size() < max_views) {
        std::size_t best = views.size();
        double most = -1.0;
        for (std::size_t i = 0; i < views.size(); ++i) {
            if (picked.contains(i)) continue;
            double gain = 0.0;
            for (const Trait& trait : traits[i])
                gain += trait.weight / (1.0 + std::pow(num_seen[trait], 2.0));
            if (gain > most) {
                most = gain;
                best = i;
            }
        }
        picked.insert(best);
        for (const Trait& trait : traits[best]) ++num_seen[trait];
    }
    std::vector<boards::BoardView> chosen;
    for (const std::size_t i : picked) chosen.push_back(views[i]);
    return chosen;
}

}  // namespace divemesh::board_calibration
