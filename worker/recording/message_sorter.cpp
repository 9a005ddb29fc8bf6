#include "worker/recording/message_sorter.hpp"

#include <Eigen/Core>
#include <cmath>

#include "schemas/error.hpp"
#include "worker/recording/image_file.hpp"
#include "worker/recording/messages.hpp"
#include "worker/recording/paired_video.hpp"

namespace divemesh::recording {
namespace {

// The depth that a pressure means: under one standard atmosphere, in sea water.
constexpr double kAtmosphere_pa = 101325.0;
constexpr double kSeaWater_pa_per_m = 1025.0 * 9.80665;

Eigen::Vector3d vector_of(const std::array<double, 3>& values) {
    return Eigen::Vector3d(values.data());
}

}  // namespace

MessageSorter::MessageSorter(const std::vector<Topic>& topics,
                             const ChosenTopics& chosen,
                             const RigFiles& rig,
                             DiveWriter& writer,
                             dive::FindingLog& findings)
    : topics_(topics), chosen_(chosen), rig_(rig), writer_(writer), findings_(findings) {}

void MessageSorter::add(const LoggedMessage& message) {
    leave_out_unreadable(message.topic, message.log_time_ns, [&] {
        if (message.topic == chosen_.left) add_image(Side::Left, message);
        if (message.topic == chosen_.right) add_image(Side::Right, message);
        if (message.topic == chosen_.imu && rig_.imu_yaml) add_imu(message);
        if (message.topic == chosen_.pressure) add_pressure(message);
    });
    last_time_ns_ = message.log_time_ns;
}

void MessageSorter::leave_out_unreadable(std::size_t topic,
                                         std::int64_t log_time_ns,
                                         const std::function<void()>& read) {
    try {
        read();
    } catch (const Error& error) {
        if (error.code() != ErrorCode::BadData) throw;
        findings_.warning("message_unreadable",
                          topics_[topic].name + " at " + std::to_string(log_time_ns) + " ns",
                          std::string("a message is left out: ") + error.what(),
                          "");
    }
}

void MessageSorter::add_image(Side side, const LoggedMessage& message) {
    const Topic& topic = topics_[message.topic];
    if (is_video(topic)) return add_video(side, message);
    MessageHeader header;
    ImageFile image;
    if (topic.type == "sensor_msgs/Image") {
        const RawImage raw = parse_image(topic.serialization, message.bytes);
        header = raw.header;
        image = image_file(raw);
    } else {
        const auto compressed = parse_compressed_image(topic.serialization, message.bytes);
        header = compressed.header;
        image = image_file(compressed);
    }
    check_size(side, image.header.width_px, image.header.height_px, topic.name);
    write(side, time_ns(message, header), image, topic.name);
}

void MessageSorter::add_video(Side side, const LoggedMessage& message) {
    const Topic& topic = topics_[message.topic];
    const auto video = parse_compressed_video(topic.serialization, message.bytes);
    write_frames(side,
                 decoder_of(side).decode(video.format, time_ns(message, video.header), video.unit),
                 topic.name);
}

void MessageSorter::finish() {
    finish_video(Side::Left, *chosen_.left);
    finish_video(Side::Right, *chosen_.right);
}

void MessageSorter::finish_video(Side side, std::size_t topic) {
    video::AccessUnitDecoder& decoder = decoder_of(side);
    const std::string& name = topics_[topic].name;
    leave_out_unreadable(topic, last_time_ns_, [&] { write_frames(side, decoder.finish(), name); });
    if (decoder.num_without_frame() == 0) return;
    findings_.warning("frames_damaged",
                      name,
                      std::to_string(decoder.num_without_frame()) +
                          " frames of video are left out, as they cannot be decoded",
                      "Frames before the first key frame, and those after a message that was lost, "
                      "need what is not there: record with more key frames.");
}

void MessageSorter::write_frames(Side side,
                                 const std::vector<video::VideoFrame>& frames,
                                 const std::string& topic) {
    for (const video::VideoFrame& frame : frames) {
        check_size(side, frame.pixels.cols, frame.pixels.rows, topic);
        write(side, frame.stamp_ns, image_file(frame), topic);
    }
}

void MessageSorter::write(Side side,
                          std::int64_t timestamp_ns,
                          const ImageFile& image,
                          const std::string& topic) {
    if (!writer_.add_image(side, timestamp_ns, image))
        findings_.warning("image_repeated",
                          topic + " at " + std::to_string(timestamp_ns) + " ns",
                          "a second image of this time is left out",
                          "");
}

void MessageSorter::add_imu(const LoggedMessage& message) {
    const auto imu = parse_imu_message(topics_[message.topic].serialization, message.bytes);
    const Eigen::Vector3d angular_velocity = vector_of(imu.angular_velocity);
    const Eigen::Vector3d acceleration = vector_of(imu.acceleration);
    if (!angular_velocity.allFinite() || !acceleration.allFinite())
        throw Error(ErrorCode::BadData, "it has a value that is not a number");
    writer_.add_imu({time_ns(message, imu.header), angular_velocity, acceleration});
}

void MessageSorter::add_pressure(const LoggedMessage& message) {
    const auto pressure = parse_fluid_pressure(topics_[message.topic].serialization, message.bytes);
    if (!std::isfinite(pressure.pressure_pa))
        throw Error(ErrorCode::BadData, "it has a value that is not a number");
    writer_.add_pressure({time_ns(message, pressure.header),
                          (pressure.pressure_pa - kAtmosphere_pa) / kSeaWater_pa_per_m});
}

// Returns when a message was measured; when it was recorded if its header does not state that.
std::int64_t MessageSorter::time_ns(const LoggedMessage& message, const MessageHeader& header) {
    if (header.timestamp_ns > 0) return header.timestamp_ns;
    findings_.warning(
        "stamp_missing",
        topics_[message.topic].name + " at " + std::to_string(message.log_time_ns) + " ns",
        "the header of a message states no time; the time of recording is used, "
        "which is later",
        "Let the driver stamp its messages.");
    return message.log_time_ns;
}

// Throws for an image of another size than the calibration's: Error{InvalidArgument} for the first
// one, as the calibration is wrong for all of them then, Error{BadData} for a later one.
void MessageSorter::check_size(Side side,
                               std::int64_t width_px,
                               std::int64_t height_px,
                               const std::string& topic) const {
    const types::Camera& camera = (side == Side::Left ? rig_.cam0 : rig_.cam1).camera;
    if (width_px == camera.width_px && height_px == camera.height_px) return;
    throw Error(writer_.num_images(side) == 0 ? ErrorCode::InvalidArgument : ErrorCode::BadData,
                topic + " has images of " + std::to_string(width_px) + " x " +
                    std::to_string(height_px) + " px, its calibration is for " +
                    std::to_string(camera.width_px) + " x " + std::to_string(camera.height_px) +
                    ": state that of these images by --calibration");
}

}  // namespace divemesh::recording
