#include <fstream>

#include "schemas/error.hpp"
#include "tests/fuzz/input.hpp"
#include "tests/temporary_folder.hpp"
#include "worker/dive/dive.hpp"

// Fuzzes a file uploaded as a dive: opens it and reads it to its end.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    static const divemesh::TemporaryFolder folder;
    const auto file = folder / "upload";
    std::ofstream(file, std::ios::binary)
        .write(reinterpret_cast<const char*>(data), static_cast<std::streamsize>(size));
    divemesh::dive::DiveLimits limits;
    limits.max_unpacked_bytes = std::int64_t{64} << 20;
    limits.max_image_pixels = 1 << 20;
    try {
        const auto dive = divemesh::dive::Dive::open(file, folder.path(), limits);
        while (dive->next_frame()) continue;
        dive->content_sha256();
        dive->duration_s();
        dive->read_reference_mesh();
    } catch (const divemesh::Error&) {
        return 0;
    }
    return 0;
}
