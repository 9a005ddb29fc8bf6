#include "worker/simulator/scene.hpp"

#include <algorithm>
#include <cmath>

#include "schemas/error.hpp"
#include "worker/base/hashed_random.hpp"

namespace divemesh::simulator {
namespace {

std::uint64_t hash_text(const std::string& text) {
    std::uint64_t hash = 0;
    for (const char c : text) hash = base::hash64(hash, static_cast<unsigned char>(c));
    return hash;
}

double volume_m3(const Shape& shape) {
    double sum = 0.0;
    for (const auto& t : shape.triangles)
        sum += shape.vertices[t[0]].dot(shape.vertices[t[1]].cross(shape.vertices[t[2]])) / 6.0F;
    return sum;
}

Eigen::AlignedBox3f bounds(const Shape& shape, const Eigen::Isometry3f& T_world_object) {
    Eigen::AlignedBox3f box;
    for (const Eigen::Vector3f& p : shape.vertices) box.extend(T_world_object * p);
    return box;
}

std::vector<Eigen::Vector3f> vertex_normals(const Shape& shape) {
    std::vector<Eigen::Vector3f> normals(shape.vertices.size(), Eigen::Vector3f::Zero());
    for (const auto& t : shape.triangles) {
        const Eigen::Vector3f& a = shape.vertices[t[0]];
        const Eigen::Vector3f weighted = (shape.vertices[t[1]] - a).cross(shape.vertices[t[2]] - a);
        for (const std::uint32_t vertex : t) normals[vertex] += weighted;
    }
    for (Eigen::Vector3f& normal : normals)
        normal = normal.norm() > 0.0F ? normal.normalized() : Eigen::Vector3f::UnitZ();
    return normals;
}

void append(Scene& scene,
            SceneObject object,
            const Shape& shape,
            const Eigen::Isometry3f& T_world_object) {
    const auto number = static_cast<std::uint16_t>(scene.objects.size());
    scene.objects.push_back(std::move(object));
    const auto offset = static_cast<std::uint32_t>(scene.vertices.size());
    for (const Eigen::Vector3f& p : shape.vertices) scene.vertices.push_back(T_world_object * p);
    for (const Eigen::Vector3f& n : vertex_normals(shape))
        scene.normals.push_back(T_world_object.linear() * n);
    for (const auto& t : shape.triangles) {
        scene.triangles.push_back({t[0] + offset, t[1] + offset, t[2] + offset});
        scene.triangle_object.push_back(number);
    }
}

}  // namespace

void add_object(Scene& scene, SceneObject object, const Shape& shape) {
    const Eigen::Isometry3f T_world_object = object.T_object_world.inverse();
    append(scene, std::move(object), shape, T_world_object);
}

SceneBuilder::SceneBuilder(std::uint64_t seed, int year, const Eigen::Isometry3f& T_world_place)
    : seed_(seed),
      year_(year),
      T_world_place_(T_world_place),
      noise_(base::hash64(seed, 0x7368617065ULL)) {}

void SceneBuilder::add(const std::string& name,
                       Material material,
                       const Shape& shape,
                       const Eigen::Isometry3f& T_place_object) {
    const Eigen::Isometry3f T_world_object = T_world_place_ * T_place_object;
    const Eigen::AlignedBox3f own = bounds(shape, Eigen::Isometry3f::Identity());
    const std::uint64_t seed = base::hash64(seed_, hash_text(name));
    const Eigen::Isometry3f T_object_world = T_world_object.inverse();
    append(scene_, {name, material, seed, T_object_world, own.sizes().x()}, shape, T_world_object);
}

void SceneBuilder::add_changing(const std::string& name,
                                Material material,
                                const Shape& shape,
                                const Eigen::Isometry3f& T_place_object,
                                Fate fate) {
    const Eigen::Isometry3f T_world_object = T_world_place_ * T_place_object;
    const bool later = year_ > 1;
    SceneChange change{.name = name};
    if (fate != Fate::New) {
        change.before_world = bounds(shape, T_world_object);
        change.volume_before_m3 = volume_m3(shape);
    }
    Shape now = shape;
    if (fate == Fate::Grows) {
        const float factor = 1.0F + static_cast<float>(year_ - 1) / 6.0F;
        for (Eigen::Vector3f& p : now.vertices) p *= factor;
    }
    const bool there = fate == Fate::Grows || (fate == Fate::New) == later;
    if (there) {
        add(name, material, now, T_place_object);
        change.after_world = bounds(now, T_world_object);
        change.volume_after_m3 = volume_m3(now);
    }
    change.kind = fate == Fate::Grows ? "growth" : (fate == Fate::Lost ? "loss" : "new");
    if (later) scene_.changes.push_back(change);
}

void SceneBuilder::add_distance(const std::string& name,
                                const std::string& what,
                                const Eigen::Vector3d& a_place,
                                const Eigen::Vector3d& b_place) {
    const Eigen::Isometry3d T_world_place = T_world_place_.cast<double>();
    scene_.distances.push_back({.distance = {.name = name,
                                             .a_world = T_world_place * a_place,
                                             .b_world = T_world_place * b_place,
                                             .distance_m = (a_place - b_place).norm()},
                                .what = what});
}

Scene SceneBuilder::finish(const SurveyPath& path, double surface_z_m) {
    scene_.path = path;
    scene_.surface_z_m = surface_z_m;
    return std::move(scene_);
}

Eigen::Isometry3f place_at(const Eigen::Vector3f& position, float yaw, float pitch, float roll) {
    Eigen::Isometry3f T = Eigen::Isometry3f::Identity();
    T.translation() = position;
    T.linear() = (Eigen::AngleAxisf(yaw, Eigen::Vector3f::UnitZ()) *
                  Eigen::AngleAxisf(pitch, Eigen::Vector3f::UnitY()) *
                  Eigen::AngleAxisf(roll, Eigen::Vector3f::UnitX()))
                     .toRotationMatrix();
    return T;
}

Scene make_scene(SceneKind kind, std::uint64_t seed, int year, double length_m) {
    switch (kind) {
        case SceneKind::Tank: return make_tank_scene(seed, year);
        case SceneKind::Barge: return make_barge_scene(seed, year);
        case SceneKind::Reef: return make_reef_scene(seed, year);
        case SceneKind::Bed: return make_bed_scene(seed, year);
        case SceneKind::Transect: return make_transect_scene(seed, year, length_m);
    }
    throw Error(ErrorCode::InvalidArgument, "unknown scene");
}

}  // namespace divemesh::simulator
