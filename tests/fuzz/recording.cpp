#include <fstream>

#include "schemas/error.hpp"
#include "tests/fuzz/input.hpp"
#include "tests/temporary_folder.hpp"
#include "worker/recording/frame_tree.hpp"
#include "worker/recording/image_file.hpp"
#include "worker/recording/message_log.hpp"
#include "worker/video/access_unit_decoder.hpp"

namespace divemesh::recording {
namespace {

void relate_frames(Serialization serialization, std::string_view bytes) {
    FrameTree frames;
    dive::FindingLog findings;
    const auto transforms = parse_transforms(serialization, bytes);
    for (const TransformMessage& transform : transforms) frames.add(transform, findings);
    for (const TransformMessage& transform : transforms)
        frames.between(transforms.front().child_frame, transform.child_frame);
}

// Decodes a message in two halves, as if it were two frames, as either codec.
void decode(std::string_view unit) {
    for (const char* codec : {"h264", "h265"}) {
        video::AccessUnitDecoder decoder;
        for (const auto part : {unit.substr(0, unit.size() / 2), unit.substr(unit.size() / 2)})
            if (!part.empty()) decoder.decode(codec, 1, part);
        decoder.finish();
    }
}

// Parses a message as each of those that a dive is made of.
void parse(std::size_t kind, Serialization serialization, std::string_view bytes) {
    if (kind == 0) image_file(parse_image(serialization, bytes));
    if (kind == 1) image_file(parse_compressed_image(serialization, bytes));
    if (kind == 2) parse_imu_message(serialization, bytes);
    if (kind == 3) parse_camera_info(serialization, bytes);
    if (kind == 4) parse_fluid_pressure(serialization, bytes);
    if (kind == 5) relate_frames(serialization, bytes);
    if (kind == 6) decode(parse_compressed_video(serialization, bytes).unit);
}

void parse_every_way(std::string_view bytes) {
    for (const auto serialization : {Serialization::Ros1, Serialization::Cdr})
        for (std::size_t kind = 0; kind < 7; ++kind) try {
                parse(kind, serialization, bytes);
            } catch (const Error&) {
                continue;
            }
}

}  // namespace
}  // namespace divemesh::recording

// Fuzzes a file given as a recording, MCAP or a ROS bag, also in SQLite, and the messages in it.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    static const divemesh::TemporaryFolder folder;
    const auto file = folder / "recording";
    std::ofstream(file, std::ios::binary)
        .write(reinterpret_cast<const char*>(data), static_cast<std::streamsize>(size));
    try {
        divemesh::dive::FindingLog findings;
        divemesh::recording::MessageLog log(file, findings);
        while (const auto message = log.next()) {
            divemesh::recording::parse_every_way(message->bytes);
        }
    } catch (const divemesh::Error&) {
        return 0;
    }
    return 0;
}
