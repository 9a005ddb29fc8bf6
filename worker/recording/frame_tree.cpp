#include "worker/recording/frame_tree.hpp"

#include <cmath>

namespace divemesh::recording {
namespace {

// Far above any robot's; a chain through all of them is followed in no time.
constexpr std::size_t kMaxFrames = 1000;
// By how much the squared norm of a quaternion may differ from 1, as tf2 has it.
constexpr double kMaxNormError = 0.01;
// Within rounding of a transform that is sent twice.
constexpr double kSameTransform = 1e-6;

// Returns the name without the slash in front of it, which tf of ROS 1 wrote.
std::string_view plain_name(std::string_view name) {
    if (name.starts_with('/')) name.remove_prefix(1);
    return name;
}

std::optional<Eigen::Isometry3d> pose_of(const TransformMessage& message) {
    const auto& q = message.rotation_xyzw;
    Eigen::Quaterniond rotation(q[3], q[0], q[1], q[2]);
    Eigen::Isometry3d T_parent_child = Eigen::Isometry3d::Identity();
    T_parent_child.translation() = Eigen::Vector3d(message.translation_m.data());
    // A comparison with NaN is false.
    if (!(std::abs(rotation.squaredNorm() - 1.0) <= kMaxNormError)) return std::nullopt;
    if (!T_parent_child.translation().allFinite()) return std::nullopt;
    T_parent_child.linear() = rotation.normalized().toRotationMatrix();
    return T_parent_child;
}

void report(const char* code,
            std::string_view child,
            const std::string& what,
            dive::FindingLog& findings) {
    findings.warning(code,
                     "tf_static: " + std::string(child),
                     what,
                     "Correct the robot's description, or state the calibration by --calibration.");
}

}  // namespace

void FrameTree::add(const TransformMessage& message, dive::FindingLog& findings) {
    const std::string_view child = plain_name(message.child_frame);
    const std::string_view parent = plain_name(message.header.frame);
    if (child.size() > kMaxName_bytes || parent.size() > kMaxName_bytes)
        return report("transform_unusable",
                      child.substr(0, kMaxName_bytes),
                      "a frame's name is longer than any robot's; the transform is left out",
                      findings);
    const auto T_parent_child = pose_of(message);
    if (!T_parent_child || child.empty() || parent.empty())
        return report("transform_unusable",
                      child,
                      "a transform is left out: its frames have no names, its numbers are not "
                      "finite or its quaternion is not of length 1",
                      findings);
    if (frames_.size() + 2 > kMaxFrames)
        return report("transform_unusable",
                      child,
                      "there are more frames than any robot has; this one is left out",
                      findings);
    const std::size_t child_at = place_of_frame(child);
    const std::size_t parent_at = place_of_frame(parent);
    TreeFrame& frame = frames_[child_at];
    if (frame.parent && frame.parent != parent_at)
        return report("transform_two_parents",
                      child,
                      "the frame has a second parent, " + std::string(parent) +
                          "; the transform to the first one is used",
                      findings);
    if (frame.parent && !frame.T_parent_frame.isApprox(*T_parent_child, kSameTransform))
        return report("transform_changed",
                      child,
                      "the transform to " + std::string(parent) +
                          " is sent again with other numbers; the first one is used",
                      findings);
    if (frame.parent) return;
    if (is_below(parent_at, child_at))
        return report(
            "transform_cycle",
            child,
            "the transform to " + std::string(parent) + " closes a cycle of frames; it is left out",
            findings);
    frame = {parent_at, *T_parent_child};
}

std::optional<Eigen::Isometry3d> FrameTree::between(std::string_view a, std::string_view b) const {
    const auto pose_a = root_pose_of(plain_name(a));
    const auto pose_b = root_pose_of(plain_name(b));
    if (!pose_a || !pose_b || pose_a->root != pose_b->root) return std::nullopt;
    return pose_a->T_root_frame.inverse() * pose_b->T_root_frame;
}

std::size_t FrameTree::place_of_frame(std::string_view name) {
    const auto [found, is_new] = places_.emplace(name, frames_.size());
    if (is_new) frames_.emplace_back();
    return found->second;
}

// Returns whether a frame is another one or below it.
bool FrameTree::is_below(std::size_t frame, std::size_t ancestor) const {
    while (frame != ancestor) {
        if (!frames_[frame].parent) return false;
        frame = *frames_[frame].parent;
    }
    return true;
}

std::optional<FrameTree::RootPose> FrameTree::root_pose_of(std::string_view name) const {
    const auto found = places_.find(name);
    if (found == places_.end()) return std::nullopt;
    RootPose pose{found->second};
    while (const auto parent = frames_[pose.root].parent) {
        pose.T_root_frame = frames_[pose.root].T_parent_frame * pose.T_root_frame;
        pose.root = *parent;
    }
    return pose;
}

}  // namespace divemesh::recording
