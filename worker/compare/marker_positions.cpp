#include "worker/compare/marker_positions.hpp"

#include <algorithm>
#include <array>
#include <cstdint>
#include <nlohmann/json.hpp>

#include "schemas/error.hpp"

namespace divemesh::compare {
namespace {

MarkerPosition position_of(const nlohmann::json& entry) {
    MarkerPosition marker;
    marker.id = entry.at("id").get<int>();
    marker.family = entry.at("family").get<std::string>();
    const auto position = entry.at("position_m").get<std::array<double, 3>>();
    const auto rows = entry.at("covariance_m2").get<std::array<std::array<double, 3>, 3>>();
    for (std::size_t row = 0; row < 3; ++row) {
        marker.p_world[static_cast<Eigen::Index>(row)] = position[row];
        for (std::size_t column = 0; column < 3; ++column)
            marker.covariance_m2(static_cast<Eigen::Index>(row),
                                 static_cast<Eigen::Index>(column)) = rows[row][column];
    }
    return marker;
}

// Returns the segment with the most frames.
int largest_segment(const nlohmann::json& metrics) {
    int largest = 0;
    std::int64_t max_num_frames = -1;
    int number = 0;
    for (const auto& segment : metrics.at("pieces")) {
        const auto num_frames = segment.at("num_frames").get<std::int64_t>();
        if (num_frames > max_num_frames) largest = number;
        max_num_frames = std::max(max_num_frames, num_frames);
        ++number;
    }
    return largest;
}

}  // namespace

std::vector<MarkerPosition> marker_positions(const io::ReconstructionFolder& folder) {
    std::vector<MarkerPosition> positions;
    const auto section = folder.metrics().find("markers");
    if (section == folder.metrics().end()) return positions;
    try {
        const int segment = largest_segment(folder.metrics());
        for (const auto& entry : section->at("markers"))
            if (entry.at("piece").get<int>() == segment) positions.push_back(position_of(entry));
    } catch (const nlohmann::json::exception& error) {
        throw Error(ErrorCode::BadData,
                    (folder.path() / "metrics.json").string() + ", markers: " + error.what());
    }
    return positions;
}

}  // namespace divemesh::compare
