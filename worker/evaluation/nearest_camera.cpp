#include "worker/evaluation/nearest_camera.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace divemesh::evaluation {
namespace {

constexpr std::size_t kRun = 32;

}  // namespace

NearestCamera::NearestCamera(std::vector<Eigen::Vector3f> positions)
    : positions_(std::move(positions)) {
    boxes_.resize((positions_.size() + kRun - 1) / kRun);
    for (std::size_t i = 0; i < positions_.size(); ++i) boxes_[i / kRun].extend(positions_[i]);
}

float NearestCamera::distance_m(const Eigen::Vector3f& point) const {
    float nearest = std::numeric_limits<float>::infinity();
    for (std::size_t run = 0; run < boxes_.size(); ++run) {
        if (boxes_[run].squaredExteriorDistance(point) >= nearest) continue;
        const std::size_t end = std::min(positions_.size(), (run + 1) * kRun);
        for (std::size_t i = run * kRun; i < end; ++i)
            nearest = std::min(nearest, (positions_[i] - point).squaredNorm());
    }
    return std::sqrt(nearest);
}

}  // namespace divemesh::evaluation
