#pragma once

#include <Eigen/Geometry>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "worker/types/breaks.hpp"

namespace divemesh::optimisation {

// Some poses of a path, the anchors, at which its corrections are estimated. A run is a part of the
// path without a motion that was not measured: between two anchors of one run corrections are
// blended, and never from one run to the next.
class AnchoredPath {
public:
    // Timestamps ascend; there is an anchor on both sides of every break.
    AnchoredPath(std::vector<std::int64_t> timestamps_ns,
                 std::vector<Eigen::Isometry3d> T_world_imu,
                 const types::Breaks& breaks_ns);

    // Two anchors of a run between which a time lies, or twice the same, and the weight of the
    // second.
    struct Place {
        std::size_t a = 0;
        std::size_t b = 0;
        double weight_b = 0.0;
    };
    Place at(std::int64_t timestamp_ns) const;

    std::size_t size() const { return timestamps_ns_.size(); }
    std::int64_t timestamp_ns(std::size_t anchor) const { return timestamps_ns_[anchor]; }
    const Eigen::Isometry3d& T_world_imu(std::size_t anchor) const { return T_world_imu_[anchor]; }
    // Returns the first anchor of the run of an anchor.
    std::size_t first_of_run(std::size_t anchor) const { return first_of_run_[anchor]; }

private:
    std::vector<std::int64_t> timestamps_ns_;
    std::vector<Eigen::Isometry3d> T_world_imu_;
    std::vector<std::size_t> first_of_run_;
    types::Breaks breaks_ns_;
};

// Returns a pose of the path after the corrections of its anchors, T_new_old.
Eigen::Isometry3d corrected(const AnchoredPath& path,
                            const std::vector<Eigen::Isometry3d>& T_new_old,
                            std::int64_t timestamp_ns,
                            const Eigen::Isometry3d& T_old_body);

}  // namespace divemesh::optimisation
