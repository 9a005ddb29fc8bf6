#pragma once

#include <atomic>
#include <cstddef>
#include <vector>

#include "worker/mesh/image_camera.hpp"
#include "worker/mesh/triangle_pixels.hpp"
#include "worker/types/mesh.hpp"

namespace divemesh::texture {

// The pixels of a triangle's corners with their inverse depths.
mesh::PixelTriangle project_face(const types::Mesh& mesh,
                                 const mesh::ImageCamera& camera,
                                 std::size_t face);
// Returns false if a corner is nearer than the least depth or behind the camera.
bool is_in_front(const mesh::PixelTriangle& corners);

// The depth of the nearest surface at each pixel of an image (Catmull 1974). Triangles with a
// corner nearer than the least depth are no part of it.
class DepthBuffer {
public:
    DepthBuffer(const types::Mesh& mesh,
                const std::vector<mesh::TriangleRun>& runs,  // those that the camera may see
                const mesh::ImageCamera& camera,
                int num_threads);

    // Returns the inverse depth, 1/m; 0 where there is no surface.
    float inverse_depth(int row, int column) const {
        return nearest_[static_cast<std::size_t>(row) * columns_ + column].load(
            std::memory_order_relaxed);
    }

private:
    void draw(const mesh::PixelTriangle& corners);

    int rows_;
    int columns_;
    std::vector<std::atomic<float>> nearest_;
};

}  // namespace divemesh::texture
