#include "tests/fuzz/input.hpp"
#include "worker/dive/frame_list.hpp"
#include "worker/dive/sensor_tables.hpp"

namespace {

using namespace divemesh::worker;

// Two lists of pictures, with an empty line between them.
void read_cameras(std::string_view text, FindingLog& findings) {
    const auto gap = text.find("\n\n");
    const auto left = parse_camera_rows(text.substr(0, gap), "cam0", findings);
    const auto right = parse_camera_rows(
        gap == std::string_view::npos ? text : text.substr(gap), "cam1", findings);
    match_pairs(left, right, findings);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    divemesh::fuzz::Input input(data, size);
    FindingLog findings;
    switch (input.choice(5)) {
        case 0: parse_imu(input.rest(), "data.csv", findings); break;
        case 1: parse_ahrs(input.rest(), "data.csv", findings); break;
        case 2: parse_pressure(input.rest(), "data.csv", findings); break;
        case 3: parse_ground_truth(input.rest(), "data.csv", findings); break;
        default: read_cameras(input.rest(), findings);
    }
    return 0;
}
