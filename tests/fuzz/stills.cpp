#include <cstddef>
#include <cstdint>
#include <optional>
#include <string_view>

#include "schemas/error.hpp"
#include "worker/recording/exif_time.hpp"
#include "worker/recording/kitti_calibration.hpp"
#include "worker/recording/raster_header.hpp"
#include "worker/recording/time_table.hpp"

// Fuzzes bytes as the EXIF and the header of an image, as a table of times and as a calibration of
// KITTI. The decoders of images are those of OpenCV.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    const std::string_view bytes(reinterpret_cast<const char*>(data), size);
    divemesh::recording::exif_time(bytes);
    divemesh::recording::convert_time_table(bytes, std::nullopt);
    divemesh::recording::convert_time_table(bytes, divemesh::recording::StampUnit::Seconds);
    divemesh::recording::kitti_cameras(bytes, 0, 1, {64, 48});
    try {
        divemesh::recording::read_raster_header(bytes);
    } catch (const divemesh::Error&) {
        return 0;
    }
    return 0;
}
