#include "worker/recording/messages.hpp"

#include "worker/recording/deserializer.hpp"

namespace divemesh::recording {
namespace {

constexpr std::int64_t kNsPerS = 1'000'000'000;
// The smallest transform: a time, the lengths of two names, seven numbers.
constexpr std::size_t kMinTransform_bytes = 8 + 2 * 4 + 7 * 8;

// Takes a time and the name of a frame. Seconds of ROS 1 have no sign.
MessageHeader take_time_and_frame(Deserializer& fields) {
    MessageHeader header;
    if (fields.is_ros1()) {
        header.timestamp_ns = fields.take<std::uint32_t>() * kNsPerS;
    } else {
        header.timestamp_ns = fields.take<std::int32_t>() * kNsPerS;
    }
    header.timestamp_ns += fields.take<std::uint32_t>();
    header.frame = fields.take_text();
    return header;
}

// Takes std_msgs/Header. That of ROS 1 begins with a number in the sequence.
MessageHeader take_header(Deserializer& fields) {
    if (fields.is_ros1()) fields.take<std::uint32_t>();
    return take_time_and_frame(fields);
}

}  // namespace

MessageHeader parse_header(Serialization serialization, std::string_view bytes) {
    Deserializer fields(serialization, bytes);
    return take_header(fields);
}

RawImage parse_image(Serialization serialization, std::string_view bytes) {
    Deserializer fields(serialization, bytes);
    RawImage image;
    image.header = take_header(fields);
    image.height_px = fields.take<std::uint32_t>();
    image.width_px = fields.take<std::uint32_t>();
    image.encoding = fields.take_text();
    image.is_big_endian = fields.take<std::uint8_t>() != 0;
    image.row_bytes = fields.take<std::uint32_t>();
    image.pixels = fields.take_bytes();
    return image;
}

CompressedImage parse_compressed_image(Serialization serialization, std::string_view bytes) {
    Deserializer fields(serialization, bytes);
    CompressedImage image;
    image.header = take_header(fields);
    image.format = fields.take_text();
    image.file = fields.take_bytes();
    return image;
}

CompressedVideo parse_compressed_video(Serialization serialization, std::string_view bytes) {
    Deserializer fields(serialization, bytes);
    CompressedVideo video;
    video.header = take_time_and_frame(fields);
    video.unit = fields.take_bytes();
    video.format = fields.take_text();
    return video;
}

ImuMessage parse_imu_message(Serialization serialization, std::string_view bytes) {
    Deserializer fields(serialization, bytes);
    ImuMessage imu;
    imu.header = take_header(fields);
    fields.take_array<double, 4 + 9>();  // orientation and its covariance
    imu.angular_velocity = fields.take_array<double, 3>();
    fields.take_array<double, 9>();  // covariance
    imu.acceleration = fields.take_array<double, 3>();
    fields.take_array<double, 9>();  // covariance
    return imu;
}

PressureMessage parse_fluid_pressure(Serialization serialization, std::string_view bytes) {
    Deserializer fields(serialization, bytes);
    PressureMessage pressure;
    pressure.header = take_header(fields);
    pressure.pressure_pa = fields.take<double>();
    return pressure;
}

CameraInfo parse_camera_info(Serialization serialization, std::string_view bytes) {
    Deserializer fields(serialization, bytes);
    CameraInfo info;
    info.frame = take_header(fields).frame;
    info.height_px = fields.take<std::uint32_t>();
    info.width_px = fields.take<std::uint32_t>();
    info.distortion_model = fields.take_text();
    info.distortion_coefficients.resize(fields.take_length(sizeof(double)));
    for (double& value : info.distortion_coefficients) value = fields.take<double>();
    info.camera_matrix = fields.take_array<double, 9>();
    info.rectification = fields.take_array<double, 9>();
    info.projection = fields.take_array<double, 12>();
    return info;
}

std::vector<TransformMessage> parse_transforms(Serialization serialization,
                                               std::string_view bytes) {
    Deserializer fields(serialization, bytes);
    std::vector<TransformMessage> transforms(fields.take_length(kMinTransform_bytes));
    for (TransformMessage& transform : transforms) {
        transform.header = take_header(fields);
        transform.child_frame = fields.take_text();
        transform.translation_m = fields.take_array<double, 3>();
        transform.rotation_xyzw = fields.take_array<double, 4>();
    }
    return transforms;
}

}  // namespace divemesh::recording
