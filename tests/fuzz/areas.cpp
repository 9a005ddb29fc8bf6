#include <algorithm>
#include <nlohmann/json.hpp>

#include "schemas/error.hpp"
#include "tests/fuzz/input.hpp"
#include "worker/reef/measure_areas.hpp"

namespace {

// What is measured, so that an input takes milliseconds.
constexpr std::size_t kMaxMeasured = 4;
constexpr double kMaxDistance_m = 4.0;

bool is_far(const divemesh::reef::Area& area) {
    return std::any_of(area.points.begin(), area.points.end(), [](const Eigen::Vector3d& point) {
        return point.norm() > kMaxDistance_m;
    });
}

// Two triangles of 2 m square, one corner raised.
divemesh::types::Mesh ground() {
    divemesh::types::Mesh mesh;
    mesh.vertices = {{0, 0, 0}, {2, 0, 0}, {2, 2, 0.5F}, {0, 2, 0}};
    mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
    return mesh;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    const auto document =
        nlohmann::json::parse(divemesh::fuzz::Input(data, size).rest(), nullptr, false);
    try {
        divemesh::reef::AreaSet set = divemesh::reef::parse_areas(document);
        set = divemesh::reef::moved(std::move(set),
                                    Eigen::Isometry3d(Eigen::Translation3d(0.1, 0.2, 0.3)));
        std::erase_if(set.areas, is_far);
        if (set.areas.size() > kMaxMeasured) set.areas.resize(kMaxMeasured);
        divemesh::reef::MeasureOptions options;
        options.num_replicates = 0;
        options.num_threads = 1;
        divemesh::reef::measure_areas(ground(), set, options);
    } catch (const divemesh::Error&) {
    }
    return 0;
}
