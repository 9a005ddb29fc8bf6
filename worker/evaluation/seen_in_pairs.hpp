#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <vector>

#include "worker/evaluation/surface_index.hpp"
#include "worker/types/recording.hpp"
#include "worker/types/rig.hpp"

namespace divemesh::evaluation {

// The stereo pairs of a dive.
struct StereoPairs {
    types::Rig rig;
    std::vector<Eigen::Isometry3d> T_world_cam0;
};

// Returns the pairs at all poses of a trajectory.
StereoPairs pairs_along(const types::Trajectory& trajectory, const types::Rig& rig);

// Tells which points of a surface the pairs of a dive saw: both images show the point within a
// range, and the surface hides it from neither camera. Of more than 2,000 pairs equal steps count,
// because a point that nothing sees is compared with all pairs near it. Thread-safe.
class SeenInPairs {
public:
    // The surface must live as long.
    SeenInPairs(const StereoPairs& pairs,
                const Eigen::Isometry3d& T_surface_world,
                const SurfaceIndex& surface,
                double max_range_m);

    // Returns true if at least so many pairs saw the point, in the frame of the surface.
    bool is_seen(const Eigen::Vector3f& point, int min_pairs) const;

private:
    struct Eye {
        explicit Eye(const types::Camera& of);
        bool shows(const Eigen::Vector3d& p_cam) const;

        types::Camera camera;
        double max_tangent;  // of an angle to the axis
    };

    bool pair_sees(const Eigen::Isometry3d& T_cam0_surface, const Eigen::Vector3d& point) const;
    bool is_hidden(const Eigen::Vector3d& camera, const Eigen::Vector3d& point) const;

    Eye left_;
    Eye right_;
    Eigen::Isometry3d T_cam1_cam0_;
    const SurfaceIndex& surface_;
    double max_range_m_;
    std::vector<Eigen::Isometry3d> T_cam0_surface_;
    std::vector<Eigen::AlignedBox3d> boxes_;  // of kRun cameras each, in the surface's frame
};

}  // namespace divemesh::evaluation
