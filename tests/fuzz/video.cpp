#include <fstream>

#include "schemas/error.hpp"
#include "tests/fuzz/input.hpp"
#include "tests/temporary_folder.hpp"
#include "worker/video/sound_envelope.hpp"
#include "worker/video/video_index.hpp"
#include "worker/video/video_reader.hpp"

// Fuzzes a file given as a video: its index, its frames and its sound.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    static const divemesh::TemporaryFolder folder;
    const auto file = folder / "video";
    std::ofstream(file, std::ios::binary)
        .write(reinterpret_cast<const char*>(data), static_cast<std::streamsize>(size));
    try {
        using divemesh::base::ignore_progress;
        const auto index = divemesh::video::read_index(file, ignore_progress);
        divemesh::video::VideoReader reader(
            file, index.stamps_ns, divemesh::video::StoredJpeg::Kept);
        while (reader.next()) continue;
        divemesh::video::read_sound(file, 10.0, ignore_progress);
    } catch (const divemesh::Error&) {
        return 0;
    }
    return 0;
}
