#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstring>
#include <string>
#include <string_view>
#include <vector>

namespace divemesh::recording {

// How a message is written: as ROS 1 does, or in CDR.
enum class Wire { Ros1, LittleCdr, BigCdr };

// Writes the fields of a message of ROS, as wiki.ros.org/msg and the CDR of DDS-XTypes 7.4.1
// describe them: in CDR a number begins at a multiple of its size behind the four bytes of the
// encapsulation.
class MessageWriter {
public:
    explicit MessageWriter(Wire wire) : wire_(wire) {
        if (wire == Wire::LittleCdr) bytes_ = std::string("\0\1\0\0", 4);
        if (wire == Wire::BigCdr) bytes_ = std::string("\0\0\0\0", 4);
    }

    template <typename Value>
    MessageWriter& put(Value value) {
        while (wire_ != Wire::Ros1 && bytes_.size() % sizeof value != 4 % sizeof value)
            bytes_.push_back('\0');
        char raw[sizeof value];
        std::memcpy(raw, &value, sizeof value);
        if (wire_ == Wire::BigCdr) std::reverse(raw, raw + sizeof value);
        bytes_.append(raw, sizeof value);
        return *this;
    }
    MessageWriter& put_text(std::string text) {
        if (wire_ != Wire::Ros1) text.push_back('\0');
        return put_bytes(text);
    }
    MessageWriter& put_bytes(std::string_view bytes) {
        put(static_cast<std::uint32_t>(bytes.size()));
        bytes_.append(bytes);
        return *this;
    }
    MessageWriter& put_all(const std::vector<double>& values) {
        for (const double value : values) put(value);
        return *this;
    }
    MessageWriter& put_header(std::int64_t timestamp_ns, const std::string& frame) {
        if (wire_ == Wire::Ros1) put(std::uint32_t{7});
        put(static_cast<std::uint32_t>(timestamp_ns / 1'000'000'000));
        put(static_cast<std::uint32_t>(timestamp_ns % 1'000'000'000));
        return put_text(frame);
    }
    const std::string& bytes() const { return bytes_; }

private:
    Wire wire_;
    std::string bytes_;
};

inline std::string image_message(Wire wire,
                                 std::int64_t timestamp_ns,
                                 const std::string& encoding,
                                 std::uint32_t width_px,
                                 std::uint32_t height_px,
                                 std::string_view pixels,
                                 const std::string& frame = "cam") {
    MessageWriter message(wire);
    message.put_header(timestamp_ns, frame).put(height_px).put(width_px).put_text(encoding);
    message.put(std::uint8_t{0}).put(static_cast<std::uint32_t>(pixels.size() / height_px));
    return message.put_bytes(pixels).bytes();
}

inline std::string compressed_image_message(Wire wire,
                                            std::int64_t timestamp_ns,
                                            std::string_view file) {
    MessageWriter message(wire);
    return message.put_header(timestamp_ns, "cam").put_text("jpeg").put_bytes(file).bytes();
}

// `rates` and `accelerations` have three numbers each.
inline std::string imu_message(Wire wire,
                               std::int64_t timestamp_ns,
                               const std::vector<double>& rates,
                               const std::vector<double>& accelerations,
                               const std::string& frame = "imu") {
    MessageWriter message(wire);
    message.put_header(timestamp_ns, frame);
    message.put_all({0, 0, 0, 1}).put_all(std::vector<double>(9, 0.5));
    message.put_all(rates).put_all(std::vector<double>(9, 0.25)).put_all(accelerations);
    return message.put_all(std::vector<double>(9, 0.125)).bytes();
}

inline std::string camera_info_message(Wire wire,
                                       std::uint32_t width_px,
                                       std::uint32_t height_px,
                                       const std::string& model,
                                       const std::vector<double>& distortion,
                                       const std::array<std::vector<double>, 3>& matrices) {
    MessageWriter message(wire);
    message.put_header(1, "cam").put(height_px).put(width_px).put_text(model);
    message.put(static_cast<std::uint32_t>(distortion.size())).put_all(distortion);
    for (const auto& matrix : matrices) message.put_all(matrix);
    for (int i = 0; i < 6; ++i) message.put(std::uint32_t{0});  // binning, region
    return message.put(std::uint8_t{0}).bytes();
}

// Where a frame is in its parent.
struct TestTransform {
    std::string parent;
    std::string child;
    std::vector<double> translation_m;
    std::vector<double> rotation_xyzw;
};

// Writes tf2_msgs/TFMessage, as tf2_msgs/msg/TFMessage.msg describes it.
inline std::string transforms_message(Wire wire, const std::vector<TestTransform>& transforms) {
    MessageWriter message(wire);
    message.put(static_cast<std::uint32_t>(transforms.size()));
    for (const TestTransform& transform : transforms) {
        message.put_header(0, transform.parent).put_text(transform.child);
        message.put_all(transform.translation_m).put_all(transform.rotation_xyzw);
    }
    return message.bytes();
}

}  // namespace divemesh::recording
