#include "worker/simulator/reference_mesh.hpp"

#include <algorithm>

#include "worker/simulator/camera_sensor.hpp"
#include "worker/simulator/surface_color.hpp"

namespace divemesh::simulator {
namespace {

constexpr float kColorFootprint_m = 0.01F;

std::vector<bool> fill_gaps(const Scene& scene, const std::vector<bool>& seen) {
    std::vector<bool> vertex_seen(scene.vertices.size(), false);
    for (std::size_t i = 0; i < seen.size(); ++i)
        if (seen[i])
            for (const std::uint32_t vertex : scene.triangles[i]) vertex_seen[vertex] = true;
    std::vector<bool> filled = seen;
    for (std::size_t i = 0; i < seen.size(); ++i)
        filled[i] = seen[i] || std::ranges::all_of(scene.triangles[i], [&](std::uint32_t vertex) {
                        return vertex_seen[vertex];
                    });
    return filled;
}

}  // namespace

types::Mesh make_reference_mesh(const Scene& scene,
                                const std::vector<bool>& seen,
                                std::uint64_t seed) {
    const std::vector<bool> kept = fill_gaps(scene, seen);
    const NoiseField noise = texture_noise(seed);
    constexpr std::uint32_t kUnused = 0xffffffffU;
    std::vector<std::uint32_t> new_index(scene.vertices.size(), kUnused);
    types::Mesh mesh;
    for (std::size_t i = 0; i < kept.size(); ++i) {
        if (!kept[i]) continue;
        std::array<std::uint32_t, 3> triangle{};
        for (std::size_t corner = 0; corner < 3; ++corner) {
            const std::uint32_t vertex = scene.triangles[i][corner];
            if (new_index[vertex] == kUnused) {
                new_index[vertex] = static_cast<std::uint32_t>(mesh.vertices.size());
                const Rgb color = surface_color(scene.objects[scene.triangle_object[i]],
                                                noise,
                                                scene.vertices[vertex],
                                                scene.normals[vertex],
                                                kColorFootprint_m);
                mesh.vertices.push_back(scene.vertices[vertex]);
                mesh.normals.push_back(scene.normals[vertex]);
                mesh.colors.push_back({tone(color[0]), tone(color[1]), tone(color[2])});
            }
            triangle[corner] = new_index[vertex];
        }
        mesh.triangles.push_back(triangle);
    }
    return mesh;
}

}  // namespace divemesh::simulator
