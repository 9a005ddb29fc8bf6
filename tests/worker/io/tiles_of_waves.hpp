#pragma once

#include <Eigen/Geometry>
#include <array>
#include <cmath>
#include <functional>
#include <nlohmann/json.hpp>

#include "tests/worker/io/test_files.hpp"
#include "worker/io/mesh_reader.hpp"
#include "worker/io/tiles_writer.hpp"

namespace divemesh::io {

inline constexpr int kNumWaveCells = 64;
inline constexpr double kWaves_m = 2.0;

inline double height_m(double x, double y) { return 0.1 * std::sin(3.0 * x) * std::cos(2.0 * y); }

// Returns a height field over a square of 2 m.
inline types::Mesh waves() {
    types::Mesh mesh;
    const auto at = [](int row, int column) {
        return static_cast<std::uint32_t>(row * (kNumWaveCells + 1) + column);
    };
    for (int row = 0; row <= kNumWaveCells; ++row)
        for (int column = 0; column <= kNumWaveCells; ++column) {
            const double x = kWaves_m * column / kNumWaveCells;
            const double y = kWaves_m * row / kNumWaveCells;
            mesh.vertices.emplace_back(x, y, height_m(x, y));
            mesh.normals.emplace_back(0.0F, 0.0F, 1.0F);
            mesh.colors.push_back({10, 200, 30});
        }
    for (int row = 0; row < kNumWaveCells; ++row)
        for (int column = 0; column < kNumWaveCells; ++column) {
            mesh.triangles.push_back({at(row, column), at(row, column + 1), at(row + 1, column)});
            mesh.triangles.push_back(
                {at(row, column + 1), at(row + 1, column + 1), at(row + 1, column)});
        }
    return mesh;
}

// A test that writes tiles into tiles/.
class TilesTest : public FileTest {
protected:
    nlohmann::json tileset() const {
        return nlohmann::json::parse(read(file("tiles/tileset.json")));
    }
    types::Mesh mesh_of(const nlohmann::json& tile) const {
        return read_mesh(file("tiles/" + tile["content"]["uri"].get<std::string>()));
    }
    static void for_each(const nlohmann::json& tile,
                         const std::function<void(const nlohmann::json&)>& act) {
        act(tile);
        for (const nlohmann::json& child : tile.value("children", nlohmann::json::array()))
            for_each(child, act);
    }
    static Eigen::AlignedBox3d box_of(const nlohmann::json& tile) {
        const auto b = tile["boundingVolume"]["box"].get<std::array<double, 12>>();
        const Eigen::Vector3d center(b[0], b[1], b[2]);
        const Eigen::Vector3d half(b[3], b[7], b[11]);
        return {center - half, center + half};
    }
};

}  // namespace divemesh::io
