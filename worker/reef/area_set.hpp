#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

namespace divemesh::reef {

// quadrat: a surveyed frame on the ground; polygon: a colony or a patch; transect: a line along
// which a chain is laid.
enum class AreaKind { Quadrat, Outline, Transect };

// The frame of the points: the reconstruction's, or that of the ground truth trajectory.
enum class AreaFrame { World, GroundTruth };

inline constexpr std::size_t kMaxAreaPoints = 1'000;

// One area to be measured.
struct Area {
    std::string name;   // unique
    std::string label;  // what it shows (species, substrate); empty: not counted
    AreaKind kind = AreaKind::Quadrat;
    std::vector<Eigen::Vector3d> points;    // m; corners in order, or the transect's line
    std::optional<Eigen::Vector3d> normal;  // unit; nullopt: that of the corners, upward
};

// The areas of one file, in one frame.
struct AreaSet {
    AreaFrame frame = AreaFrame::World;
    std::vector<Area> areas;
};

// Read {"frame": "world" | "ground_truth", "areas": [{"name", "label"?, "kind"?: "quadrat" |
// "polygon" | "transect", "corners" | "polygon" | "line": [[x, y, z], ...] in m, "normal"?: [x, y,
// z]}]}. Throw Error{NotFound}, or Error{BadData}, which names the area and its fault: fewer than
// three points (two of a transect), a number that is not finite, no area, sides that cross.
AreaSet read_areas(const std::filesystem::path& file);
AreaSet parse_areas(const nlohmann::json& document);

// Returns the areas transformed from another frame into `world`.
AreaSet moved(AreaSet set, const Eigen::Isometry3d& T_world_frame);

std::string_view to_string(AreaKind kind);

}  // namespace divemesh::reef
