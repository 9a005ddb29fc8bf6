#include "worker/recording/import_recording.hpp"

#include <algorithm>
#include <utility>

#include "schemas/content_hash.hpp"
#include "schemas/error.hpp"
#include "worker/dive/image.hpp"
#include "worker/recording/dive_writer.hpp"
#include "worker/recording/message_sorter.hpp"

namespace divemesh::recording {
namespace {

constexpr std::int64_t kHashed_bytes = std::int64_t{1} << 20U;  // at a time

std::string sha256_of(const InputFile& file) {
    Sha256 hash;
    for (std::int64_t at = 0; at < file.size_bytes(); at += kHashed_bytes)
        hash.update(file.read(at, kHashed_bytes));
    return hash.hex();
}

Provenance provenance_of(const InputFile& file,
                         Naming naming,
                         const std::vector<Finding>& findings) {
    const std::string name = file.path().filename().string();
    Provenance provenance{name, sha256_of(file), file.size_bytes(), findings};
    if (naming == Naming::AfterFile) return provenance;
    provenance.file.clear();
    for (Finding& finding : provenance.findings)
        if (finding.where.starts_with(name)) finding.where.replace(0, name.size(), "recording");
    return provenance;
}

std::vector<double> size_of(const LoggedMessage& message, const Topic& topic) {
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
    log.rewind();
    while (const auto message = log.next()) try {
            if (message->topic == topic) return size_of(*message, topics[topic]);
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
            "State it by divemesh import --calibration: T_BS of both cameras relative to the IMU.");
    DiveWriter writer(options_.out, options_.durability);
    MessageSorter sorter(topics(), chosen_, rig, writer, findings_);
    log_.rewind();
    std::int64_t num_read = 0;
    while (const auto message = log_.next()) {
        const double part = static_cast<double>(num_read++);
        progress({"import", 0.5 + 0.5 * part / static_cast<double>(log_.num_messages())});
        sorter.add(*message);
    }
    if (writer.num_images(Side::Left) == 0 || writer.num_images(Side::Right) == 0)
        throw Error(ErrorCode::BadData,
                    "no image of one of the cameras can be read" +
                        (findings().empty() ? std::string() : ": " + findings().front().message));
    if (writer.num_pressures() > 0)
        findings_.info(
            "pressure_converted",
            topics()[*chosen_.pressure].name,
            "depth is computed from pressure for sea water of 1025 kg/m^3 under 101325 Pa");
    writer.commit(rig, provenance_of(InputFile(options_.recording), options_.naming, findings()));
    return {writer.num_images(Side::Left),
            writer.num_images(Side::Right),
            writer.num_imu(),
            writer.num_pressures()};
}

RigFiles RecordingImport::find_rig() {
    if (!options_.calibration.empty()) return read_rig(options_.calibration, findings_, hints());
    const auto left = first_info(chosen_.left_info);
    const auto right = first_info(chosen_.right_info);
    if (!left || !right)
        throw Error(ErrorCode::BadData,
                    "the recording has no CameraInfo beside the images of " +
                        topics()[left ? *chosen_.right : *chosen_.left].name +
                        ": state the calibration by --calibration");
    return rig_of_infos(*left, *right, rectification(), findings_);
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

// Returns the first message of a topic that is a CameraInfo.
std::optional<CameraInfo> RecordingImport::first_info(std::optional<std::size_t> topic) {
    if (!topic) return std::nullopt;
    log_.rewind();
    while (const auto message = log_.next()) {
        if (message->topic != topic) continue;
        try {
            return parse_camera_info(topics()[*topic].serialization, message->bytes);
        } catch (const Error& error) {
            findings_.warning("message_unreadable",
                              topics()[*topic].name,
                              std::string("a message is left out: ") + error.what(),
                              "");
        }
    }
    return std::nullopt;
}

}  // namespace divemesh::recording
