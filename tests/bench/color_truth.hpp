#pragma once

#include <Eigen/Geometry>
#include <array>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "worker/simulator/noise_field.hpp"
#include "worker/simulator/ray_caster.hpp"
#include "worker/simulator/scene.hpp"
#include "worker/types/raster_grid.hpp"

namespace divemesh::bench {

using LinearRgb = std::array<double, 3>;

// The scene of a simulated dive with the reflectance of its surface.
class AlbedoScene {
public:
    AlbedoScene(const std::string& scene, std::uint64_t seed, double length_m);

    // A place on the surface, in the world of the scene.
    struct Place {
        Eigen::Vector3f p;
        LinearRgb albedo = {};
    };
    // Returns where a ray meets the surface first, as seen by a pixel of a size.
    std::optional<Place> first_hit(const Eigen::Vector3f& origin,
                                   const Eigen::Vector3f& direction,
                                   float pixel_m,
                                   float max_m) const;

private:
    simulator::Scene scene_;
    simulator::RayCaster caster_;
    simulator::NoiseField noise_;
};

// Returns T_scene_world of a reconstruction, by the path.
Eigen::Isometry3d align_with_scene(const std::filesystem::path& model,
                                   const std::filesystem::path& dive);

// The mosaic of a reconstruction, in squares of a centimetre.
struct MosaicSquares {
    int columns = 0;
    int rows = 0;
    double side_m = 0.0;
    types::RasterGrid grid;
    std::vector<std::optional<LinearRgb>> colors;  // nullopt: not all of the square is surface

    static MosaicSquares of(const std::filesystem::path& model);

    Eigen::Vector2d center(int column, int row) const;
    const std::optional<LinearRgb>& at(int column, int row) const {
        return colors[static_cast<std::size_t>(row) * static_cast<std::size_t>(columns) +
                      static_cast<std::size_t>(column)];
    }
    // Returns the colour of the square at a point; nullopt outside.
    std::optional<LinearRgb> at(const Eigen::Vector2d& point) const;
};

// A colour as shown with what it should be.
struct ColorPair {
    LinearRgb shown = {};
    LinearRgb truth = {};
};

// Returns the squares of a mosaic with the reflectance of the surface seen from above.
std::vector<ColorPair> mosaic_pairs(const MosaicSquares& mosaic,
                                    const AlbedoScene& scene,
                                    const Eigen::Isometry3d& T_scene_world);
// Returns the vertices of mesh.ply, at most 50,000, with the reflectance of the surface there.
std::vector<ColorPair> vertex_pairs(const std::filesystem::path& model,
                                    const AlbedoScene& scene,
                                    const Eigen::Isometry3d& T_scene_world);
// Returns the squares of one mosaic with those of another of the same places.
std::vector<ColorPair> common_pairs(const MosaicSquares& one,
                                    const Eigen::Isometry3d& T_scene_one,
                                    const MosaicSquares& other,
                                    const Eigen::Isometry3d& T_scene_other,
                                    const AlbedoScene& scene);

// Returns the median dE 2000 after one gain per channel, the median of the ratios, is applied to
// what is shown; or without it.
double median_error(const std::vector<ColorPair>& pairs, bool with_gains);

}  // namespace divemesh::bench
