#pragma once

#include <Eigen/Geometry>
#include <array>
#include <cstdint>
#include <opencv2/core/mat.hpp>
#include <string>
#include <vector>

#include "worker/dive/dive.hpp"
#include "worker/simulator/diver_motion.hpp"
#include "worker/simulator/noise_field.hpp"
#include "worker/simulator/shapes.hpp"
#include "worker/simulator/simulate.hpp"

namespace divemesh::simulator {

// clang-format off
enum class Material { Deck, Timber, Iron, Sand, Rock, Coral, BranchCoral, Sponge,
                      Brick, Carpet, Cardboard, Wood, Drum, ScaleBar, Marker };
// clang-format on

// One thing in the scene; its texture is fixed to its own coordinates.
struct SceneObject {
    std::string name;
    Material material = Material::Rock;
    std::uint64_t seed = 0;  // shifts and tints the texture
    Eigen::Isometry3f T_object_world = Eigen::Isometry3f::Identity();
    float length_m = 0.0F;  // of the shape along its x axis
    cv::Mat tag;  // of a marker: one pixel a cell, in the middle of its face, x right, y up
    float cell_m = 0.0F;
};

// What a year did to one object: what a comparison of both dives should find.
struct SceneChange {
    std::string name;
    std::string kind;                  // growth, loss, new
    Eigen::AlignedBox3f before_world;  // empty for what is new
    Eigen::AlignedBox3f after_world;   // empty for what was lost
    double volume_before_m3 = 0.0;     // of the closed shape, buried parts included
    double volume_after_m3 = 0.0;
};

// A measured length as written to measurements.json.
struct SceneDistance {
    dive::KnownDistance distance;
    std::string what;
};

// A place: one triangle surface in the world (z up), and how it is surveyed.
struct Scene {
    std::vector<Eigen::Vector3f> vertices;
    std::vector<Eigen::Vector3f> normals;  // of the vertices, outward
    std::vector<std::array<std::uint32_t, 3>> triangles;
    std::vector<std::uint16_t> triangle_object;
    std::vector<SceneObject> objects;
    std::vector<SceneDistance> distances;
    std::vector<SceneChange> changes;  // since year 1
    SurveyPath path;
    double surface_z_m = 0.0;  // of the water
};

constexpr double kMaxTransectLength_m = 400.0;  // by the memory that its triangles take

// The same seed gives the same place; later years change single objects of it and nothing else. A
// transect goes on for `length_m`; the others have their size.
Scene make_scene(SceneKind kind, std::uint64_t seed, int year, double length_m);
Scene make_tank_scene(std::uint64_t seed, int year);
Scene make_barge_scene(std::uint64_t seed, int year);
Scene make_reef_scene(std::uint64_t seed, int year);
Scene make_bed_scene(std::uint64_t seed, int year);
Scene make_transect_scene(std::uint64_t seed, int year, double length_m);

// Puts an object with this shape into the scene; `object` says how it looks and where it is.
void add_object(Scene& scene, SceneObject object, const Shape& shape);

// Collects objects into a scene.
class SceneBuilder {
public:
    // Everything stands in a frame of its own, a little askew in the world as real places are.
    SceneBuilder(std::uint64_t seed, int year, const Eigen::Isometry3f& T_world_place);

    // Texture seeds hang on the name, so that objects keep their look when others come or go.
    void add(const std::string& name,
             Material material,
             const Shape& shape,
             const Eigen::Isometry3f& T_place_object);
    // Grows by a sixth a year from the second year on, or is gone, or is new, by `fate`.
    enum class Fate { Grows, Lost, New };
    void add_changing(const std::string& name,
                      Material material,
                      const Shape& shape,
                      const Eigen::Isometry3f& T_place_object,
                      Fate fate);
    // Ends in the frame of the place.
    void add_distance(const std::string& name,
                      const std::string& what,
                      const Eigen::Vector3d& a_place,
                      const Eigen::Vector3d& b_place);

    const NoiseField& noise() const { return noise_; }
    std::uint64_t seed() const { return seed_; }
    Scene finish(const SurveyPath& path, double surface_z_m);

private:
    Scene scene_;
    std::uint64_t seed_;
    int year_;
    Eigen::Isometry3f T_world_place_;
    NoiseField noise_;
};

// x y z in m and turns in rad, yaw first.
Eigen::Isometry3f place_at(const Eigen::Vector3f& position,
                           float yaw = 0.0F,
                           float pitch = 0.0F,
                           float roll = 0.0F);

}  // namespace divemesh::simulator
