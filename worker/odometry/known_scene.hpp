#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <map>
#include <optional>

#include "worker/odometry/register_points.hpp"
#include "worker/types/feature.hpp"
#include "worker/types/rectified_rig.hpp"

namespace divemesh::odometry {

// The static scene of the last seconds: features that have kept to their first position in the
// world for some time. It protects the motion from something large that moves by itself and soon
// fills most of the image: a board that is carried past, a buddy, a shoal. Features that have just
// appeared confirm a motion of the known scene, but do not outvote it.
class KnownScene {
public:
    explicit KnownScene(const types::RectifiedRig& rig) : rig_(rig) {}

    // Takes in a frame whose motion vision measured.
    void update(const PointPairs& pairs,
                const Registration& vision,
                const Eigen::Isometry3d& T_world_previous,
                std::int64_t before_ns,
                std::int64_t now_ns);

    // Returns the pairs of known features.
    PointPairs known(const PointPairs& pairs) const;
    // Returns true if the known features contradict the motion of `pairs`: it would leave enough
    // of those in `previous` in sight, but was found by others, or many of them do not follow it.
    bool contradicts(const types::Features& previous,
                     const PointPairs& pairs,
                     const Registration& vision) const;
    // Returns true if enough known features support a motion that is the predicted one within some
    // pixels: it needs no confirmation, however many others contradict it.
    bool confirms(const Registration& vision,
                  const std::optional<Eigen::Isometry3d>& expected) const;
    // Returns true if the feature has followed the scene's motion, however briefly.
    bool has_followed(std::int64_t id) const { return points_.contains(id); }
    // Returns true if almost no known feature supports a motion and most of its inliers lie in
    // front of the known scene: something passes in between. `T_world_previous` is the pose from
    // which the motion leads to the current frame.
    bool is_hidden_behind(const Registration& vision,
                          const Eigen::Isometry3d& T_world_previous) const;

private:
    struct Point {
        Eigen::Vector3d p_world;  // as first seen
        std::int64_t first_ns = 0;
        std::int64_t last_ns = 0;
        bool known = false;
    };
    bool knows(std::int64_t id) const;
    bool stays(const Point& point,
               const PointPair& pair,
               const Eigen::Isometry3d& T_current_world) const;

    types::RectifiedRig rig_;
    std::map<std::int64_t, Point> points_;  // by feature
};

}  // namespace divemesh::odometry
