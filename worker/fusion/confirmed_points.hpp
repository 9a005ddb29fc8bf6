#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <deque>
#include <functional>
#include <vector>

#include "worker/fusion/octree_volume.hpp"

namespace divemesh::fusion {

// The points of octrees that a volume confirms: points that only one view saw or that other views
// looked through are left out. Points are streamed; only one bit per point is held.
class ConfirmedPoints {
public:
    // `points` and `volume` must outlive this object and must not change.
    ConfirmedPoints(const std::deque<PointOctree>& points, const Volume& volume, int num_threads);

    std::int64_t size() const { return num_confirmed_; }
    void for_each(const std::function<void(const Eigen::Vector3f& p_world, const types::Color&)>&
                      visit) const;

private:
    const std::deque<PointOctree>& points_;
    std::vector<bool> confirmed_;  // in the order of the octrees
    std::int64_t num_confirmed_ = 0;
};

}  // namespace divemesh::fusion
