#include "tests/fuzz/input.hpp"
#include "worker/dive/frame_list.hpp"
#include "worker/dive/sensor_tables.hpp"

namespace {

// Two lists of images, with an empty line between them.
void read_cameras(std::string_view text, divemesh::dive::FindingLog& findings) {
    const auto gap = text.find("\n\n");
    const auto left = divemesh::dive::parse_camera_rows(text.substr(0, gap), "cam0", findings);
    const auto right = divemesh::dive::parse_camera_rows(
        gap == std::string_view::npos ? text : text.substr(gap), "cam1", findings);
    divemesh::dive::match_pairs(left,
                                right,
                                divemesh::dive::guess_clock_difference(left, right),
                                divemesh::dive::common_clock_tolerance_ns(left));
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    divemesh::fuzz::Input input(data, size);
    divemesh::dive::FindingLog findings;
    switch (input.choice(5)) {
        case 0: divemesh::dive::parse_imu(input.rest(), "data.csv", findings); break;
        case 1: divemesh::dive::parse_ahrs(input.rest(), "data.csv", findings); break;
        case 2: divemesh::dive::parse_pressure(input.rest(), "data.csv", findings); break;
        case 3: divemesh::dive::parse_ground_truth(input.rest(), "data.csv", findings); break;
        default: read_cameras(input.rest(), findings);
    }
    return 0;
}
