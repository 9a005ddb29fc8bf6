#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

namespace divemesh::reef {

// quadrat: a frame laid on the ground, what is surveyed; polygon: a colony or a patch; transect: a
// line along which a chain is laid.
enum class AreaKind { Quadrat, Outline, Transect };

// Of the points: the reconstruction's, or the ground truth's that a trajectory is aligned with.
enum class AreaFrame { World, GroundTruth };

struct Area {
    std::string name;   // unique
    std::string label;  // what it shows (species, substrate); empty: nothing is counted
    AreaKind kind = AreaKind::Quadrat;
    std::vector<Eigen::Vector3d> points;    // m; corners in order, or the transect's line
    std::optional<Eigen::Vector3d> normal;  // unit; nothing: of the corners, upward
};

struct AreaSet {
    AreaFrame frame = AreaFrame::World;
    std::vector<Area> areas;
};

// {"frame": "world" | "ground_truth", "areas": [{"name", "label"?, "kind"?: "quadrat" | "polygon" |
// "transect", "corners" | "polygon" | "line": [[x, y, z], ...] in m, "normal"?: [x, y, z]}]}.
// Throws Error{NotFound}, or Error{BadData} that names the area and what is wrong with it: fewer
// than three points (two of a transect), a number that is not finite, no area, sides that cross.
AreaSet read_areas(const std::filesystem::path& file);
AreaSet parse_areas(const nlohmann::json& document);

// The same ground in another frame, which becomes `world`.
AreaSet moved(AreaSet set, const Eigen::Isometry3d& T_world_frame);

std::string_view to_string(AreaKind kind);

}  // namespace divemesh::reef
