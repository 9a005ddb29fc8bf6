#include "worker/recording/rig_messages.hpp"

#include <algorithm>
#include <utility>

#include "schemas/error.hpp"
#include "worker/base/text.hpp"

namespace divemesh::recording {
namespace {

// No rig is larger; a dive is refused beyond.
constexpr double kMaxRigSize_m = 5.0;

// Collects what the messages of a recording say of its rig.
class RigReader {
public:
    RigReader(MessageLog& log, const ChosenTopics& chosen, dive::FindingLog& findings)
        : log_(log), chosen_(chosen), findings_(findings) {
        for (const std::size_t topic : chosen.transforms)
            num_transforms_ += log.topics()[topic].num_messages;
    }

    RigMessages read() {
        log_.rewind();
        while (!is_complete()) {
            const auto message = log_.next();
            if (!message) break;
            try {
                add(*message);
            } catch (const Error& error) {
                findings_.warning("message_unreadable",
                                  log_.topics()[message->topic].name,
                                  std::string("a message is left out: ") + error.what(),
                                  "");
            }
        }
        if (rig_.left_frame.empty() && rig_.left_info) rig_.left_frame = rig_.left_info->frame;
        if (rig_.right_frame.empty() && rig_.right_info) rig_.right_frame = rig_.right_info->frame;
        return std::move(rig_);
    }

private:
    void add(const LoggedMessage& message) {
        const Topic& topic = log_.topics()[message.topic];
        const Serialization serialization = topic.serialization;
        const auto frame_of_images = [&] {
            return is_video(topic)
                       ? parse_compressed_video(serialization, message.bytes).header.frame
                       : parse_header(serialization, message.bytes).frame;
        };
        const auto is_first = [&](std::optional<std::size_t> wanted, bool& was_seen) {
            return message.topic == wanted && !std::exchange(was_seen, true);
        };
        if (message.topic == chosen_.left_info && !rig_.left_info)
            rig_.left_info = parse_camera_info(serialization, message.bytes);
        if (message.topic == chosen_.right_info && !rig_.right_info)
            rig_.right_info = parse_camera_info(serialization, message.bytes);
        if (is_first(chosen_.left, saw_left_)) rig_.left_frame = frame_of_images();
        if (is_first(chosen_.right, saw_right_)) rig_.right_frame = frame_of_images();
        if (is_first(chosen_.imu, saw_imu_))
            rig_.imu_frame = parse_header(serialization, message.bytes).frame;
        if (std::ranges::count(chosen_.transforms, message.topic) == 0) return;
        --num_transforms_;
        for (const TransformMessage& transform : parse_transforms(serialization, message.bytes))
            rig_.frames.add(transform, findings_);
    }

    bool is_complete() const {
        if (chosen_.left_info && !rig_.left_info) return false;
        if (chosen_.right_info && !rig_.right_info) return false;
        if (chosen_.transforms.empty()) return true;  // frames alone say nothing
        return saw_left_ && saw_right_ && (saw_imu_ || !chosen_.imu) && num_transforms_ <= 0;
    }

    MessageLog& log_;
    const ChosenTopics& chosen_;
    dive::FindingLog& findings_;
    std::int64_t num_transforms_ = 0;  // messages that are still to come
    bool saw_left_ = false;
    bool saw_right_ = false;
    bool saw_imu_ = false;
    RigMessages rig_;
};

// Returns T_a_b between two sensors' frames; nullopt with a warning if there is no such transform.
std::optional<Eigen::Isometry3d> pose_between(const FrameTree& frames,
                                              const std::string& a,
                                              const std::string& b,
                                              dive::FindingLog& findings) {
    auto T_a_b = frames.between(a, b);
    const std::string names = "'" + a + "' and '" + b + "'";
    if (T_a_b && T_a_b->translation().norm() <= kMaxRigSize_m) return T_a_b;
    const std::string what = T_a_b ? "tf_static puts the frames " + names + " of the sensors " +
                                         base::significant(T_a_b->translation().norm()) +
                                         " m apart, too far for a rig"
                                   : "tf_static has no chain of transforms between the frames " +
                                         names + " that the sensors' messages name";
    findings.warning("frames_unrelated",
                     "tf_static",
                     what,
                     "Record tf_static with all frames, or state the calibration by "
                     "--calibration.");
    return std::nullopt;
}

}  // namespace

RigMessages read_rig_messages(MessageLog& log,
                              const ChosenTopics& chosen,
                              dive::FindingLog& findings) {
    return RigReader(log, chosen, findings).read();
}

RigPoses poses_of_frames(const RigMessages& messages, dive::FindingLog& findings) {
    RigPoses poses;
    if (messages.frames.is_empty() || messages.left_frame.empty()) return poses;
    // Both cameras of a rectified pair name the left one's frame: it says nothing of their poses.
    if (!messages.right_frame.empty() && messages.left_frame != messages.right_frame)
        poses.T_cam0_cam1 =
            pose_between(messages.frames, messages.left_frame, messages.right_frame, findings);
    if (!messages.imu_frame.empty())
        poses.T_imu_cam0 =
            pose_between(messages.frames, messages.imu_frame, messages.left_frame, findings);
    return poses;
}

}  // namespace divemesh::recording
