#include "worker/texture/depth_buffer.hpp"

#include "worker/base/parallel.hpp"

namespace divemesh::texture {

mesh::PixelTriangle project_face(const types::Mesh& mesh,
                                 const mesh::ImageCamera& camera,
                                 std::size_t face) {
    const auto& [a, b, c] = mesh.triangles[face];
    return {camera.project(mesh.vertices[a]),
            camera.project(mesh.vertices[b]),
            camera.project(mesh.vertices[c])};
}

bool is_in_front(const mesh::PixelTriangle& corners) {
    return corners[0].z() > 0.0F && corners[1].z() > 0.0F && corners[2].z() > 0.0F;
}

DepthBuffer::DepthBuffer(const types::Mesh& mesh,
                         const std::vector<mesh::TriangleRun>& runs,
                         const mesh::ImageCamera& camera,
                         int num_threads)
    : rows_(camera.rows),
      columns_(camera.columns),
      nearest_(static_cast<std::size_t>(camera.rows) * camera.columns) {
    base::for_each_index(num_threads, runs.size(), [&](std::size_t i) {
        for (std::size_t face = runs[i].begin; face < runs[i].end; ++face) {
            const mesh::PixelTriangle corners = project_face(mesh, camera, face);
            if (is_in_front(corners)) draw(corners);
        }
    });
}

// The greatest of several values is the same in any order of the threads.
void DepthBuffer::draw(const mesh::PixelTriangle& corners) {
    mesh::for_each_pixel(
        corners,
        rows_,
        columns_,
        [&](int row, int column, const Eigen::Vector3f&, float inverse_depth) {
            auto& nearest = nearest_[static_cast<std::size_t>(row) * columns_ + column];
            float known = nearest.load(std::memory_order_relaxed);
            while (known < inverse_depth && !nearest.compare_exchange_weak(
                                                known, inverse_depth, std::memory_order_relaxed)) {
            }
        });
}

}  // namespace divemesh::texture
