#include "worker/io/tiles_writer.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>
#include <optional>
#include <vector>

#include "schemas/error.hpp"
#include "worker/base/atomic_file.hpp"
#include "worker/io/geographic_frame.hpp"
#include "worker/io/glb_writer.hpp"
#include "worker/io/mesh_check.hpp"
#include "worker/io/seamed_mesh.hpp"
#include "worker/io/tile_texture.hpp"

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

// Cesium and its like refine a tile whose error is more than 16 px on the screen.
constexpr double kErrorOfTexel = 16.0;

// Returns the centre and the three half axes, as boundingVolume.box has them.
json box_json(const Box& box) {
    const Eigen::Vector3d center = box.center();
    const Eigen::Vector3d half = 0.5 * box.sizes();
    return {center.x(), center.y(), center.z(), half.x(), 0, 0, 0, half.y(), 0, 0, 0, half.z()};
}

// What a tile is for the tile above it.
struct Tile {
    std::vector<Triangle> triangles;
    double simplification_m = 0.0;  // error of these triangles
    double error_m = 0.0;           // of what is shown
    int num_halvings = 0;           // of its texture
    Box box;                        // of all triangles that they stand for
    json description;
};

class TilesWriter {
public:
    TilesWriter(const std::filesystem::path& folder,
                const types::Mesh& mesh,
                const StoredTexture* texture,
                const TilesDescription& limits)
        : folder_(folder),
          surface_(mesh, texture, texture == nullptr ? 0 : texture->jpegs.size()),
          limits_(limits) {
        if (texture != nullptr) atlases_.emplace(*texture);
    }

    Tile write_all() { return write(surface_.triangles(), "", 0); }

private:
    // Writes a tile and all below it. Its name tells the quadrants that lead to it.
    Tile write(std::vector<Triangle> triangles, const std::string& name, int depth) {
        Tile tile;
        for (const Triangle& triangle : triangles)
            for (const std::uint32_t vertex : triangle)
                tile.box.extend(surface_.vertices()[vertex].cast<double>());
        json children = json::array();
        if (depth == kMaxDepth || fits(triangles)) {
            tile.triangles = std::move(triangles);
        } else {
            add_children(std::move(triangles), name, depth, tile, children);
            simplify(tile);
        }
        const std::string file = (name.empty() ? "root" : name) + ".glb";
        write_content(folder_ / file, !children.empty(), tile);
        tile.description["boundingVolume"] = {{"box", box_json(tile.box)}};
        tile.description["geometricError"] = tile.error_m;
        tile.description["refine"] = "REPLACE";
        tile.description["content"] = {{"uri", file}};
        if (!children.empty()) tile.description["children"] = std::move(children);
        return tile;
    }

    // Returns whether triangles can be a leaf.
    bool fits(const std::vector<Triangle>& triangles) {
        if (triangles.size() > limits_.max_triangles) return false;
        if (!atlases_) return true;
        const SeamedPart part = surface_.part(triangles);
        return TileTexture(part.mesh, part.map, *atlases_).num_texels(0) <= limits_.max_texels;
    }

    void write_content(const std::filesystem::path& file, bool has_children, Tile& tile) {
        tile.error_m = std::max(tile.error_m, tile.simplification_m);
        const SeamedPart part = surface_.part(tile.triangles);
        if (!atlases_) return write_glb(file, part.mesh, nullptr, GlbCompression::Meshopt);
        const TileTexture shown(part.mesh, part.map, *atlases_);
        if (has_children) tile.num_halvings = num_halvings(shown, tile.num_halvings + 1);
        const types::Texture packed = shown.pack(tile.num_halvings);
        write_glb(file, part.mesh, &packed, GlbCompression::Meshopt);
        const double texel_m = std::ldexp(shown.texel_m(), tile.num_halvings);
        if (has_children) tile.error_m = std::max(tile.error_m, kErrorOfTexel * texel_m);
        tile.description["extras"] = {{"simplification_m", tile.simplification_m},
                                      {"texel_m", texel_m}};
    }

    // Returns how often to halve a texture until it fits, as long as that makes it much smaller.
    int num_halvings(const TileTexture& texture, int least) const {
        int num = least;
        while (texture.num_texels(num) > limits_.max_texels &&
               2 * texture.num_texels(num + 1) < texture.num_texels(num))
            ++num;
        return num;
    }

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
                sum += surface_.vertices()[vertex].cast<double>();
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
            tile.simplification_m = std::max(tile.simplification_m, child.simplification_m);
            tile.error_m = std::max(tile.error_m, child.error_m);
            tile.num_halvings = std::max(tile.num_halvings, child.num_halvings);
            children.push_back(std::move(child.description));
        }
    }

    // Simplifies the triangles of the tiles below with the smallest tolerance that leaves no more
    // than a tile may have.
    void simplify(Tile& tile) const {
        const double below_m = tile.simplification_m;
        const std::vector<Triangle> below = std::move(tile.triangles);
        tile.triangles = below;
        double tolerance_m = std::max(kFirstTolerance * tile.box.sizes().maxCoeff(), below_m);
        for (int i = 0; i < kNumTolerances; ++i, tolerance_m *= 2.0) {
            std::vector<Triangle> fewer = surface_.simplified(below, tolerance_m);
            if (fewer.empty()) return;
            tile.triangles = std::move(fewer);
            tile.simplification_m = below_m + tolerance_m;
            if (tile.triangles.size() <= limits_.max_triangles) return;
        }
    }

    const std::filesystem::path& folder_;
    SeamedMesh surface_;
    std::optional<AtlasImages> atlases_;  // nullopt: the vertices have the colours
    const TilesDescription& limits_;
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
                 const StoredTexture* texture,
                 const TilesDescription& description) {
    check_mesh(mesh);
    if (texture != nullptr) check_texture_map(mesh, *texture, texture->jpegs.size());
    if (mesh.triangles.empty())
        throw Error(ErrorCode::BadData,
                    "the mesh has no triangles to cut into tiles: reconstruct the dive with a "
                    "surface");
    std::filesystem::create_directories(folder);
    Tile root = TilesWriter(folder, mesh, texture, description).write_all();
    if (description.position) root.description["transform"] = transform_json(*description.position);
    const json tileset = {{"asset", {{"version", "1.1"}, {"extras", {{"text", description.text}}}}},
                          {"geometricError", std::max(root.box.sizes().norm(), root.error_m)},
                          {"root", std::move(root.description)}};
    base::write_file(folder / "tileset.json", tileset.dump(1) + "\n");
}

}  // namespace divemesh::io
