#pragma once

#include <Eigen/Geometry>
#include <cstddef>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "worker/dive/finding_log.hpp"
#include "worker/recording/messages.hpp"

namespace divemesh::recording {

// The frames of a robot and where each is in its parent, as tf_static relates them. What would make
// it other than trees is left out as it is added, so that a chain of frames always ends.
class FrameTree {
public:
    // Adds where a frame is in its parent. A transform that is none, a second parent, a cycle and a
    // changed transform are warnings; the first transform of a frame is kept.
    void add(const TransformMessage& message, dive::FindingLog& findings);
    bool is_empty() const { return frames_.empty(); }
    // Returns T_a_b, which maps coordinates in frame b to those in frame a; nullopt if no chain of
    // transforms joins the two.
    std::optional<Eigen::Isometry3d> between(std::string_view a, std::string_view b) const;

private:
    struct TreeFrame {
        std::optional<std::size_t> parent;  // nullopt: a root
        Eigen::Isometry3d T_parent_frame = Eigen::Isometry3d::Identity();
    };
    struct RootPose {
        std::size_t root = 0;
        Eigen::Isometry3d T_root_frame = Eigen::Isometry3d::Identity();
    };
    std::size_t place_of_frame(std::string_view name);
    bool is_below(std::size_t frame, std::size_t ancestor) const;
    std::optional<RootPose> root_pose_of(std::string_view name) const;

    std::vector<TreeFrame> frames_;
    std::map<std::string, std::size_t, std::less<>> places_;
};

}  // namespace divemesh::recording
