#include "worker/io/tiles_writer.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>
#include <unordered_map>
#include <vector>

#include "schemas/error.hpp"
#include "worker/base/atomic_file.hpp"
#include "worker/io/geographic_frame.hpp"
#include "worker/io/glb_writer.hpp"
#include "worker/io/mesh_check.hpp"
#include "worker/mesh/simplify_group.hpp"

namespace divemesh::io {
namespace {

using nlohmann::json;
using Triangle = std::array<std::uint32_t, 3>;
using Box = Eigen::AlignedBox3d;

// A wall seen from above cannot be cut further.
constexpr int kMaxDepth = 12;
// Each tolerance is twice the one before. The first is a thousandth of a tile's size, less than a
// pixel where the tile fills a screen.
constexpr double kFirstTolerance = 1e-3;
constexpr int kNumTolerances = 6;

// The part of a mesh that some triangles use, with what a viewer shows.
types::Mesh part_of_mesh(const types::Mesh& mesh, const std::vector<Triangle>& triangles) {
    types::Mesh part;
    std::unordered_map<std::uint32_t, std::uint32_t> number_of;
    for (Triangle triangle : triangles) {
        for (std::uint32_t& vertex : triangle) {
            const auto [found, is_new] =
                number_of.try_emplace(vertex, static_cast<std::uint32_t>(part.vertices.size()));
            if (is_new) {
                part.vertices.push_back(mesh.vertices[vertex]);
                if (!mesh.normals.empty()) part.normals.push_back(mesh.normals[vertex]);
                if (!mesh.colors.empty()) part.colors.push_back(mesh.colors[vertex]);
            }
            vertex = found->second;
        }
        part.triangles.push_back(triangle);
    }
    return part;
}

// Returns the centre and the three half axes, as boundingVolume.box has them.
json box_json(const Box& box) {
    const Eigen::Vector3d center = box.center();
    const Eigen::Vector3d half = 0.5 * box.sizes();
    return {center.x(), center.y(), center.z(), half.x(), 0, 0, 0, half.y(), 0, 0, 0, half.z()};
}

// What a tile is for the tile above it.
struct Tile {
    std::vector<Triangle> triangles;
    double error_m = 0.0;  // of these triangles
    Box box;               // of all triangles that they stand for
    json description;
};

class TilesWriter {
public:
    TilesWriter(const std::filesystem::path& folder,
                const types::Mesh& mesh,
                std::size_t max_triangles)
        : folder_(folder), mesh_(mesh), max_triangles_(max_triangles) {}

    // Writes a tile and all below it. Its name tells the quadrants that lead to it.
    Tile write(std::vector<Triangle> triangles, const std::string& name, int depth) {
        Tile tile;
        for (const Triangle& triangle : triangles)
            for (const std::uint32_t vertex : triangle)
                tile.box.extend(mesh_.vertices[vertex].cast<double>());
        json children = json::array();
        if (triangles.size() <= max_triangles_ || depth == kMaxDepth) {
            tile.triangles = std::move(triangles);
        } else {
            add_children(std::move(triangles), name, depth, tile, children);
            simplify(tile);
        }
        const std::string file = (name.empty() ? "root" : name) + ".glb";
        write_glb(
            folder_ / file, part_of_mesh(mesh_, tile.triangles), nullptr, GlbCompression::Meshopt);
        tile.description = {{"boundingVolume", {{"box", box_json(tile.box)}}},
                            {"geometricError", tile.error_m},
                            {"refine", "REPLACE"},
                            {"content", {{"uri", file}}}};
        if (!children.empty()) tile.description["children"] = std::move(children);
        return tile;
    }

private:
    void add_children(std::vector<Triangle> triangles,
                      const std::string& name,
                      int depth,
                      Tile& tile,
                      json& children) {
        std::array<std::vector<Triangle>, 4> quadrants;
        const Eigen::Vector3d center = tile.box.center();
        for (const Triangle& triangle : triangles) {
            Eigen::Vector3d sum = Eigen::Vector3d::Zero();
            for (const std::uint32_t vertex : triangle)
                sum += mesh_.vertices[vertex].cast<double>();
            const std::size_t quadrant =
                (sum.x() > 3.0 * center.x() ? 1U : 0U) + (sum.y() > 3.0 * center.y() ? 2U : 0U);
            quadrants[quadrant].push_back(triangle);
        }
        triangles = {};
        for (std::size_t i = 0; i < quadrants.size(); ++i) {
            if (quadrants[i].empty()) continue;
            Tile child = write(std::move(quadrants[i]), name + std::to_string(i), depth + 1);
            tile.triangles.insert(
                tile.triangles.end(), child.triangles.begin(), child.triangles.end());
            tile.error_m = std::max(tile.error_m, child.error_m);
            children.push_back(std::move(child.description));
        }
    }

    // Simplifies the triangles of the tiles below with the smallest tolerance that leaves no more
    // than a tile may have.
    void simplify(Tile& tile) const {
        const double below_m = tile.error_m;
        const std::vector<Triangle> below = std::move(tile.triangles);
        tile.triangles = below;
        double tolerance_m = std::max(kFirstTolerance * tile.box.sizes().maxCoeff(), below_m);
        for (int i = 0; i < kNumTolerances; ++i, tolerance_m *= 2.0) {
            std::vector<Triangle> fewer =
                mesh::collapse_within_border(mesh_.vertices, below, tolerance_m);
            if (fewer.empty()) return;
            tile.triangles = std::move(fewer);
            tile.error_m = below_m + tolerance_m;
            if (tile.triangles.size() <= max_triangles_) return;
        }
    }

    const std::filesystem::path& folder_;
    const types::Mesh& mesh_;
    std::size_t max_triangles_;
};

// Returns the pose of the world in earth-centred, earth-fixed coordinates, column by column.
json transform_json(const types::GeographicPosition& position) {
    json columns = json::array();
    const Eigen::Matrix4d T_earth_world = earth_from_world(position).matrix();
    for (int column = 0; column < 4; ++column)
        for (int row = 0; row < 4; ++row) columns.push_back(T_earth_world(row, column));
    return columns;
}

}  // namespace

void write_tiles(const std::filesystem::path& folder,
                 const types::Mesh& mesh,
                 const TilesDescription& description) {
    check_mesh(mesh);
    if (mesh.triangles.empty())
        throw Error(ErrorCode::BadData,
                    "the mesh has no triangles to cut into tiles: reconstruct the dive with a "
                    "surface");
    std::filesystem::create_directories(folder);
    Tile root = TilesWriter(folder, mesh, description.max_triangles).write(mesh.triangles, "", 0);
    if (description.position) root.description["transform"] = transform_json(*description.position);
    const json tileset = {{"asset", {{"version", "1.1"}, {"extras", {{"text", description.text}}}}},
                          {"geometricError", std::max(root.box.sizes().norm(), root.error_m)},
                          {"root", std::move(root.description)}};
    base::write_file(folder / "tileset.json", tileset.dump(1) + "\n");
}

}  // namespace divemesh::io
