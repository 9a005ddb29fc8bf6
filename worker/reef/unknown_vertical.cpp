#include "worker/reef/unknown_vertical.hpp"

#include <algorithm>
#include <set>
#include <string>

#include "worker/reef/area_plane.hpp"
#include "worker/reef/measure_areas.hpp"

namespace divemesh::reef {
namespace {

constexpr const char* kReason =
    "no sensor tells which way is up in this dive: draw an area by its corners, or record an IMU, "
    "an AHRS or a depth sensor on the next dive";

// Returns the names of the areas whose heights are along the vertical.
std::set<std::string> along_vertical(const AreaSet& set) {
    std::set<std::string> names = {std::string(kWholeModel)};
    for (const Area& area : set.areas)
        if (area.kind == AreaKind::Transect && !area.normal) names.insert(area.name);
    return names;
}

// Returns whether a metric of an area along the vertical depends on it. The size of a colony lies
// in the plane of its own corners; the ground that colonies are counted over does not.
bool needs_vertical(const nlohmann::json& metric) {
    if (metric["area"] != kWholeModel || !metric.contains("label")) return true;
    return metric["figure"] == "population_density" || metric["figure"] == "cover";
}

}  // namespace

AreaSet facing_cameras(AreaSet set, const std::vector<Eigen::Vector3d>& camera_positions_world) {
    if (camera_positions_world.empty()) return set;
    for (Area& area : set.areas) {
        if (area.kind == AreaKind::Transect || area.normal) continue;
        const Eigen::Vector3d normal = upward_normal(area.points);
        if (normal.isZero()) continue;  // plane_of() refuses it
        const Eigen::Vector3d& corner = area.points.front();
        const Eigen::Vector3d nearest = *std::ranges::min_element(
            camera_positions_world, {}, [&](const Eigen::Vector3d& camera) {
                return (camera - corner).squaredNorm();
            });
        area.normal = normal.dot(nearest - corner) < 0.0 ? Eigen::Vector3d(-normal) : normal;
    }
    return set;
}

void refuse_by_vertical(const AreaSet& set, nlohmann::json& result) {
    const std::set<std::string> names = along_vertical(set);
    for (nlohmann::json& metric : result["figures"]) {
        const std::string figure = metric["figure"];
        if (figure != "slope" && figure != "aspect" &&
            !(names.contains(metric["area"].get<std::string>()) && needs_vertical(metric)))
            continue;
        for (const char* key : {"value", "low", "high", "method"}) metric.erase(key);
        metric["refused"] = kReason;
    }
    for (nlohmann::json& area : result["areas"])
        if (area["name"].get<std::string>() == kWholeModel) area.erase("planar_area_m2");
}

}  // namespace divemesh::reef
