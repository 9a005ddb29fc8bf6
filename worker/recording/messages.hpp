#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "worker/recording/container.hpp"

// The messages of ROS that a dive is made of, and their parsers. All throw Error{BadData} with the
// reason if the bytes are not such a message. Views are into the bytes.
namespace divemesh::recording {

// When and in which frame a message was measured.
struct MessageHeader {
    std::int64_t timestamp_ns = 0;  // 0: not stated
    std::string_view frame;
};

// sensor_msgs/Image
struct RawImage {
    MessageHeader header;
    std::uint32_t width_px = 0;
    std::uint32_t height_px = 0;
    std::string_view encoding;  // "mono8", "bgr8" ...
    bool is_big_endian = false;
    std::uint32_t row_bytes = 0;
    std::string_view pixels;
};

// sensor_msgs/CompressedImage
struct CompressedImage {
    MessageHeader header;
    std::string_view format;
    std::string_view file;  // PNG or JPEG, as it is
};

// foxglove_msgs/CompressedVideo: one frame of a stream, which may need those before.
struct CompressedVideo {
    MessageHeader header;
    std::string_view unit;
    std::string_view format;  // "h264" or "h265"; others exist
};

// sensor_msgs/Imu
struct ImuMessage {
    MessageHeader header;
    std::array<double, 3> angular_velocity{};  // rad/s
    std::array<double, 3> acceleration{};      // m/s^2, specific force
};

// sensor_msgs/FluidPressure
struct PressureMessage {
    MessageHeader header;
    double pressure_pa = 0.0;  // absolute
};

// sensor_msgs/CameraInfo. R maps the camera to its rectified frame, P is the projection there.
struct CameraInfo {
    std::string frame;
    std::uint32_t width_px = 0;
    std::uint32_t height_px = 0;
    std::string distortion_model;
    std::vector<double> distortion_coefficients;
    std::array<double, 9> camera_matrix{};
    std::array<double, 9> rectification{};
    std::array<double, 12> projection{};
};

// geometry_msgs/TransformStamped of tf2_msgs/TFMessage: where a frame is in that of the header.
struct TransformMessage {
    MessageHeader header;
    std::string_view child_frame;
    std::array<double, 3> translation_m{};
    std::array<double, 4> rotation_xyzw{};
};

// Returns the header that messages of sensors begin with.
MessageHeader parse_header(Serialization serialization, std::string_view bytes);
RawImage parse_image(Serialization serialization, std::string_view bytes);
CompressedImage parse_compressed_image(Serialization serialization, std::string_view bytes);
CompressedVideo parse_compressed_video(Serialization serialization, std::string_view bytes);
ImuMessage parse_imu_message(Serialization serialization, std::string_view bytes);
PressureMessage parse_fluid_pressure(Serialization serialization, std::string_view bytes);
CameraInfo parse_camera_info(Serialization serialization, std::string_view bytes);
std::vector<TransformMessage> parse_transforms(Serialization serialization, std::string_view bytes);

}  // namespace divemesh::recording
