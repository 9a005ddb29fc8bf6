#include "worker/recording/import_recording.hpp"

#include <algorithm>
#include <utility>

#include "schemas/error.hpp"
#include "worker/dive/image.hpp"
#include "worker/recording/bag_folder.hpp"
#include "worker/recording/dive_writer.hpp"
#include "worker/recording/imu_clock.hpp"
#include "worker/recording/message_sorter.hpp"
#include "worker/recording/provenance.hpp"
#include "worker/video/access_unit_decoder.hpp"

namespace divemesh::recording {
namespace {

Provenance provenance_of(const std::filesystem::path& recording,
                         Naming naming,
                         const std::vector<Finding>& findings) {
    const auto path = recording.has_filename() ? recording : recording.parent_path();
    Provenance provenance{
        .name = path.stem().string(),
        .files = {imported_file(path.filename().string(), files_of_recording(path))},
        .findings = findings};
    if (naming == Naming::Unnamed) remove_names(provenance);
    return provenance;
}

// Returns width and height of the image of a message; {} if a decoder needs more messages for it.
std::vector<double> size_of(const LoggedMessage& message,
                            const Topic& topic,
                            video::AccessUnitDecoder& decoder) {
    if (is_video(topic)) {
        const auto video = parse_compressed_video(topic.serialization, message.bytes);
        const auto frames = decoder.decode(video.format, message.log_time_ns, video.unit);
        if (frames.empty()) return {};
        const cv::Mat& first = frames.front().pixels;
        return {static_cast<double>(first.cols), static_cast<double>(first.rows)};
    }
    if (topic.type.ends_with("CompressedImage")) {
        const auto image = parse_compressed_image(topic.serialization, message.bytes);
        const auto header = dive::read_image_header(image.file);
        return {static_cast<double>(header.width_px), static_cast<double>(header.height_px)};
    }
    const auto image = parse_image(topic.serialization, message.bytes);
    return {static_cast<double>(image.width_px), static_cast<double>(image.height_px)};
}

// Returns width and height of the first image of a topic that can be read; {} if there is none.
std::vector<double> size_of_images(MessageLog& log,
                                   const std::vector<Topic>& topics,
                                   std::size_t topic) {
    video::AccessUnitDecoder decoder;
    log.rewind();
    while (const auto message = log.next()) try {
            if (message->topic != topic) continue;
            if (auto size = size_of(*message, topics[topic], decoder); !size.empty()) return size;
        } catch (const Error&) {
            continue;  // it is reported where images are written
        }
    return {};
}

}  // namespace

RecordingImport::RecordingImport(ImportOptions options, const base::ProgressCallback& progress)
    : options_(std::move(options)),
      log_(options_.recording, findings_, progress),
      chosen_(choose_topics(log_.topics(), options_.topics)) {}

ImportCounts RecordingImport::write(const base::ProgressCallback& progress) {
    if (!chosen_.problem.empty()) throw Error(ErrorCode::InvalidArgument, chosen_.problem);
    const RigFiles rig = find_rig();
    if (chosen_.imu && !rig.imu_yaml)
        findings_.warning(
            "imu_left_out",
            topics()[*chosen_.imu].name,
            "the IMU is left out: where it is relative to the cameras is not known",
            "Record tf_static, or state it by divemesh import --calibration: T_BS of both cameras "
            "relative to the IMU.");
    DiveWriter writer(options_.out, options_.durability);
    MessageSorter sorter(topics(), chosen_, rig, writer, findings_);
    log_.rewind();
    std::int64_t num_read = 0;
    while (const auto message = log_.next()) {
        const double part = static_cast<double>(num_read++);
        progress({"import", 0.5 + 0.5 * part / static_cast<double>(log_.num_messages())});
        sorter.add(*message);
    }
    sorter.finish();
    apply_imu_shift(rig, writer, findings_);
    if (writer.num_images(Side::Left) == 0 || writer.num_images(Side::Right) == 0)
        throw Error(ErrorCode::BadData,
                    "no image of one of the cameras can be read" +
                        (findings().empty() ? std::string() : ": " + findings().front().message));
    if (writer.num_pressures() > 0)
        findings_.info(
            "pressure_converted",
            topics()[*chosen_.pressure].name,
            "depth is computed from pressure for sea water of 1025 kg/m^3 under 101325 Pa");
    writer.commit(rig, provenance_of(options_.recording, options_.naming, findings()));
    return {writer.num_images(Side::Left),
            writer.num_images(Side::Right),
            writer.num_imu(),
            writer.num_pressures()};
}

RigFiles RecordingImport::find_rig() {
    if (!options_.calibration.empty()) return read_rig(options_.calibration, findings_, hints());
    const RigMessages rig_messages = read_rig_messages(log_, chosen_, findings_);
    if (!rig_messages.left_info || !rig_messages.right_info)
        throw Error(ErrorCode::BadData,
                    "the recording has no CameraInfo beside the images of " +
                        topics()[rig_messages.left_info ? *chosen_.right : *chosen_.left].name +
                        ": state the calibration by --calibration");
    return rig_of_infos(*rig_messages.left_info,
                        *rig_messages.right_info,
                        rectification(),
                        poses_of_frames(rig_messages, findings_),
                        findings_);
}

Rectification RecordingImport::rectification() const {
    return is_rectified(topics()[*chosen_.left]) ? Rectification::Rectified : Rectification::Raw;
}

RigHints RecordingImport::hints() {
    return {rectification(),
            size_of_images(log_, topics(), *chosen_.left),
            topics()[*chosen_.left].name,
            topics()[*chosen_.right].name,
            options_.metres_per_unit};
}

}  // namespace divemesh::recording
