#include "worker/recording/message_sorter.hpp"

#include <Eigen/Core>
#include <cmath>

#include "schemas/error.hpp"
#include "worker/recording/image_file.hpp"
#include "worker/recording/messages.hpp"

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
    try {
        if (message.topic == chosen_.left) add_image(Side::Left, message);
        if (message.topic == chosen_.right) add_image(Side::Right, message);
        if (message.topic == chosen_.imu && rig_.imu_yaml) add_imu(message);
        if (message.topic == chosen_.pressure) add_pressure(message);
    } catch (const Error& error) {
        if (error.code() != ErrorCode::BadData) throw;
        findings_.warning(
            "message_unreadable",
            topics_[message.topic].name + " at " + std::to_string(message.log_time_ns) + " ns",
            std::string("a message is left out: ") + error.what(),
            "");
    }
}

void MessageSorter::add_image(Side side, const LoggedMessage& message) {
    const Topic& topic = topics_[message.topic];
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
    check_size(side, image, topic.name);
    const std::int64_t timestamp_ns = time_ns(message, header);
    if (!writer_.add_image(side, timestamp_ns, image))
        findings_.warning("image_repeated",
                          topic.name + " at " + std::to_string(timestamp_ns) + " ns",
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
void MessageSorter::check_size(Side side, const ImageFile& image, const std::string& topic) const {
    const types::Camera& camera = (side == Side::Left ? rig_.cam0 : rig_.cam1).camera;
    if (image.header.width_px == camera.width_px && image.header.height_px == camera.height_px)
        return;
    throw Error(writer_.num_images(side) == 0 ? ErrorCode::InvalidArgument : ErrorCode::BadData,
                topic + " has images of " + std::to_string(image.header.width_px) + " x " +
                    std::to_string(image.header.height_px) + " px, its calibration is for " +
                    std::to_string(camera.width_px) + " x " + std::to_string(camera.height_px) +
                    ": state that of these images by --calibration");
}

}  // namespace divemesh::recording
