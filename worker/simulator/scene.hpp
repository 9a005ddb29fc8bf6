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

// One object in the scene; its texture is fixed to its own coordinates.
struct SceneObject {
    std::string name;
    Material material = Material::Rock;
    std::uint64_t seed = 0;  // shifts and tints the texture
    Eigen::Isometry3f T_object_world = Eigen::Isometry3f::Identity();
    float length_m = 0.0F;  // of the shape along its x axis
    cv::Mat tag;  // of a marker: one pixel per cell, in the centre of its face, x right, y up
    float cell_m = 0.0F;
};

// The change of one object after a year, which a comparison of both dives should find.
struct SceneChange {
    std::string name;
    std::string kind;                  // growth, loss, new
    Eigen::AlignedBox3f before_world;  // empty if new
    Eigen::AlignedBox3f after_world;   // empty if lost
    double volume_before_m3 = 0.0;     // of the closed shape, buried parts included
    double volume_after_m3 = 0.0;
};

// A measured length as written to measurements.json.
struct SceneDistance {
    dive::KnownDistance distance;
    std::string what;
};

// A place: one triangle surface in the world (z up), and its survey path.
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

constexpr double kMaxTransectLength_m = 400.0;  // limited by the memory of its triangles

// Returns the place of a seed; later years change only single objects of it. A transect is
// `length_m` long; the other scenes have a fixed size.
Scene make_scene(SceneKind kind, std::uint64_t seed, int year, double length_m);
Scene make_tank_scene(std::uint64_t seed, int year);
Scene make_barge_scene(std::uint64_t seed, int year);
Scene make_reef_scene(std::uint64_t seed, int year);
Scene make_bed_scene(std::uint64_t seed, int year);
Scene make_transect_scene(std::uint64_t seed, int year, double length_m);

// Adds an object of this shape to the scene; `object` describes its appearance and pose.
void add_object(Scene& scene, SceneObject object, const Shape& shape);

// Builds a scene from objects.
class SceneBuilder {
public:
    // Objects are placed in the frame of the place, which is slightly rotated in the world like
    // real places.
    SceneBuilder(std::uint64_t seed, int year, const Eigen::Isometry3f& T_world_place);

    // Adds an object. The texture seed depends on the name, so that objects keep their appearance
    // when others are added or removed.
    void add(const std::string& name,
             Material material,
             const Shape& shape,
             const Eigen::Isometry3f& T_place_object);
    // Adds an object that changes by `fate`: it grows by a sixth a year from the second year on, is
    // lost, or is new.
    enum class Fate { Grows, Lost, New };
    void add_changing(const std::string& name,
                      Material material,
                      const Shape& shape,
                      const Eigen::Isometry3f& T_place_object,
                      Fate fate);
    // Adds a known distance; its ends are in the frame of the place.
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

// Returns a pose from x y z in m and angles in rad, applied yaw first.
Eigen::Isometry3f place_at(const Eigen::Vector3f& position,
                           float yaw = 0.0F,
                           float pitch = 0.0F,
                           float roll = 0.0F);

}  // namespace divemesh::simulator
