#include "worker/io/mcap_writer.hpp"

#include <limits>

#include "worker/io/foxglove_messages.hpp"
#include "worker/io/mcap_file.hpp"
#include "worker/io/posed_images.hpp"

namespace divemesh::io {
namespace {

constexpr const char* kWorld = "world";
constexpr const char* kBody = "body";
constexpr const char* kCamera = "cam0";

// The topics of a file, and how its messages come into it.
class McapWriter {
public:
    explicit McapWriter(const std::filesystem::path& file)
        : file_(file),
          pose_(add_channel("/pose", "foxglove.PoseInFrame")),
          transform_(add_channel("/tf", "foxglove.FrameTransform")),
          cloud_(add_channel("/cloud", "foxglove.PointCloud")),
          image_(add_channel("/cam0/image", "foxglove.CompressedImage")),
          calibration_(add_channel("/cam0/calibration", "foxglove.CameraCalibration")) {}

    void add_cloud(std::int64_t timestamp_ns, const types::Mesh& cloud) {
        file_.add_message(cloud_, timestamp_ns, point_cloud(timestamp_ns, kWorld, cloud));
    }
    void add_pose(const types::StampedPose& pose) {
        const std::int64_t time = pose.timestamp_ns;
        file_.add_message(pose_, time, pose_in_frame(time, kWorld, pose.T_world_imu));
        file_.add_message(transform_, time, frame_transform(time, kWorld, kBody, pose.T_world_imu));
    }
    void add_keyframe(std::int64_t time, const PosedImages& images, const PosedImage& image) {
        file_.add_message(
            transform_, time, frame_transform(time, kWorld, kCamera, image.T_world_cam));
        file_.add_message(calibration_, time, camera_calibration(time, kCamera, images));
        file_.add_message(
            image_, time, compressed_image(time, kCamera, read_image_bytes(image.file)));
    }
    void commit(const std::string& remark) { file_.commit("divemesh", {{"certificate", remark}}); }

private:
    std::uint16_t add_channel(const char* topic, const char* schema) {
        return file_.add_channel(topic, schema, foxglove_schema(schema));
    }

    McapFile file_;
    std::uint16_t pose_;
    std::uint16_t transform_;
    std::uint16_t cloud_;
    std::uint16_t image_;
    std::uint16_t calibration_;
};

}  // namespace

void write_mcap(const std::filesystem::path& file,
                const ReconstructionFolder& reconstruction,
                const types::Mesh& cloud,
                const std::string& remark) {
    const types::Trajectory poses = reconstruction.trajectory();
    const std::vector<KeyframePose> keyframes = reconstruction.keyframes();
    const PosedImages images = read_posed_images(reconstruction);
    McapWriter writer(file);
    if (!poses.empty()) writer.add_cloud(poses.front().timestamp_ns, cloud);
    std::size_t next = 0;  // keyframe
    const auto add_keyframes_until = [&](std::int64_t timestamp_ns) {
        for (; next < keyframes.size() && keyframes[next].timestamp_ns <= timestamp_ns; ++next)
            writer.add_keyframe(keyframes[next].timestamp_ns, images, images.images[next]);
    };
    for (const types::StampedPose& pose : poses) {
        writer.add_pose(pose);
        add_keyframes_until(pose.timestamp_ns);
    }
    add_keyframes_until(std::numeric_limits<std::int64_t>::max());
    writer.commit(remark);
}

}  // namespace divemesh::io
