#include "worker/recording/import_recording.hpp"

#include <algorithm>
#include <utility>

#include "schemas/error.hpp"
#include "worker/recording/dive_writer.hpp"
#include "worker/recording/message_sorter.hpp"
#include "worker/recording/provenance.hpp"

namespace divemesh::recording {

RecordingImport::RecordingImport(ImportOptions options, const base::ProgressCallback& progress)
    : options_(std::move(options)),
      log_(options_.recording, findings_, progress),
      chosen_(choose_topics(log_.topics(), options_.topics)) {}

ImportCounts RecordingImport::write(const base::ProgressCallback& progress) {
    if (!chosen_.problem.empty()) throw Error(ErrorCode::InvalidArgument, chosen_.problem);
    const RigFiles rig = find_rig();
    if (chosen_.imu && !rig.imu_yaml)
        findings_.warning("imu_left_out",
                          topics()[*chosen_.imu].name,
                          "the IMU is left out: where it is relative to the cameras is not known",
                          "State it by --calibration: T_BS of both cameras relative to the IMU.");
    DiveWriter writer(options_.out);
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
    writer.commit(rig, {provenance_of(InputFile(options_.recording))});
    return {writer.num_images(Side::Left),
            writer.num_images(Side::Right),
            writer.num_imu(),
            writer.num_pressures()};
}

RigFiles RecordingImport::find_rig() {
    if (!options_.calibration.empty()) return rig_of_folder(options_.calibration, findings_);
    const auto left = first_info(chosen_.left_info);
    const auto right = first_info(chosen_.right_info);
    if (!left || !right)
        throw Error(ErrorCode::BadData,
                    "the recording has no CameraInfo beside the images of " +
                        topics()[left ? *chosen_.right : *chosen_.left].name +
                        ": state the calibration by --calibration");
    const bool is_rect = is_rectified(topics()[*chosen_.left]);
    return rig_of_infos(
        *left, *right, is_rect ? Rectification::Rectified : Rectification::Raw, findings_);
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
