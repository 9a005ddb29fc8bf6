#include "worker/volume/confirmed_points.hpp"

namespace divemesh::worker {
namespace {

constexpr std::size_t kPointsPerTrim = std::size_t{1} << 18;

}  // namespace

ConfirmedPoints::ConfirmedPoints(const PointOctree& points, const Volume& volume)
    : points_(points) {
    confirmed_.reserve(static_cast<std::size_t>(points.num_points()));
    points.for_each([&](const Eigen::Vector3i& cell, const PointLeaf& leaf) {
        if (confirmed_.size() % kPointsPerTrim == 0) volume.trim();
        const bool confirmed = volume.confirms(points.position(cell, leaf));
        confirmed_.push_back(confirmed);
        num_confirmed_ += confirmed ? 1 : 0;
    });
}

void ConfirmedPoints::for_each(
    const std::function<void(const Eigen::Vector3f& p_world, const Color&)>& visit) const {
    std::size_t i = 0;
    points_.for_each([&](const Eigen::Vector3i& cell, const PointLeaf& leaf) {
        if (confirmed_[i++]) visit(points_.position(cell, leaf).cast<float>(), leaf_color(leaf));
    });
}

}  // namespace divemesh::worker
