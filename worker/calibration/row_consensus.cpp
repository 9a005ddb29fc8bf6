#include "worker/calibration/row_consensus.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "worker/base/hashed_random.hpp"

namespace divemesh::calibration {
namespace {

constexpr int kNumDraws = 300;  // finds three inliers among 25 % of inliers with probability 0.99
constexpr std::uint64_t kSeed = 24;
constexpr double kToleranceShare = 0.004;  // of the height

// Row offset = plane . (x, y, 1), with x and y in focal lengths from the principal point.
using Plane = Eigen::Vector3d;

Eigen::Vector3d place_of(const types::RectifiedRig& rig, const types::StereoMatch& match) {
    return rig.point_cam(match.left_px.x(), match.left_px.y(), 1.0);
}

double row_offset_px(const types::StereoMatch& match) {
    return match.right_px.y() - match.left_px.y();
}

bool agrees(const types::RectifiedRig& rig, const Plane& plane, const types::StereoMatch& match) {
    return std::abs(plane.dot(place_of(rig, match)) - row_offset_px(match)) <
           kToleranceShare * rig.height_px;
}

Plane drawn_plane(const types::RectifiedRig& rig,
                  const types::StereoMatches& matches,
                  base::RandomRow& random) {
    Eigen::Matrix3d places;
    Eigen::Vector3d offsets_px;
    for (int i = 0; i < 3; ++i) {
        const types::StereoMatch& match = matches[random.next() % matches.size()];
        places.row(i) = place_of(rig, match);
        offsets_px[i] = row_offset_px(match);
    }
    return places.fullPivLu().solve(offsets_px);
}

}  // namespace

types::StereoMatches agreeing_rows(const types::RectifiedRig& rig,
                                   const types::StereoMatches& matches) {
    if (matches.size() < 3) return {};
    base::RandomRow random(kSeed);
    const auto num_agreeing = [&](const Plane& plane) {
        return std::ranges::count_if(
            matches, [&](const types::StereoMatch& match) { return agrees(rig, plane, match); });
    };
    Plane best = Plane::Zero();  // the stated calibration wins a tie
    std::ptrdiff_t max_agreeing = num_agreeing(best);
    for (int i = 0; i < kNumDraws; ++i) {
        const Plane plane = drawn_plane(rig, matches, random);
        const std::ptrdiff_t num = num_agreeing(plane);
        if (num <= max_agreeing) continue;
        best = plane;
        max_agreeing = num;
    }
    types::StereoMatches agreeing;
    std::ranges::copy_if(matches,
                         std::back_inserter(agreeing),
                         [&](const types::StereoMatch& match) { return agrees(rig, best, match); });
    return agreeing;
}

}  // namespace divemesh::calibration
