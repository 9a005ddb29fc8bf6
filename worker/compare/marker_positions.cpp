#include "worker/compare/marker_positions.hpp"

#include <array>
#include <nlohmann/json.hpp>

#include "schemas/error.hpp"
#include "worker/evaluation/tracking_segments.hpp"

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

}  // namespace

std::vector<MarkerPosition> marker_positions(const io::ReconstructionFolder& folder) {
    std::vector<MarkerPosition> positions;
    const auto section = folder.metrics().find("markers");
    if (section == folder.metrics().end()) return positions;
    const std::size_t segment = evaluation::number_of_largest(folder.segments());
    try {
        for (const auto& entry : section->at("markers"))
            if (entry.at("piece").get<std::size_t>() == segment)
                positions.push_back(position_of(entry));
    } catch (const nlohmann::json::exception& error) {
        throw Error(ErrorCode::BadData,
                    (folder.path() / "metrics.json").string() + ", markers: " + error.what());
    }
    return positions;
}

}  // namespace divemesh::compare
