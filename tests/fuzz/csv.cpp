#include "tests/fuzz/input.hpp"
#include "worker/dive/frame_list.hpp"
#include "worker/dive/position_tables.hpp"
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

void read_control_points(std::string_view text, divemesh::dive::FindingLog& findings) {
    divemesh::types::OutsidePositions outside;
    divemesh::dive::parse_control_points(text, outside, findings);
    divemesh::dive::to_common_system(outside, findings);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    divemesh::fuzz::Input input(data, size);
    divemesh::dive::FindingLog findings;
    switch (input.choice(8)) {
        case 0: divemesh::dive::parse_imu(input.rest(), "data.csv", findings); break;
        case 1: divemesh::dive::parse_ahrs(input.rest(), "data.csv", findings); break;
        case 2: divemesh::dive::parse_pressure(input.rest(), "data.csv", findings); break;
        case 3: divemesh::dive::parse_ground_truth(input.rest(), "data.csv", findings); break;
        case 4: read_cameras(input.rest(), findings); break;
        case 5: divemesh::dive::parse_positions(input.rest(), 4326, "data.csv", findings); break;
        case 6: divemesh::dive::parse_velocities(input.rest(), "data.csv", findings); break;
        default: read_control_points(input.rest(), findings);
    }
    return 0;
}
