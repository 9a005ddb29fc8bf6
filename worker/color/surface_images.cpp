#include "worker/color/surface_images.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdint>

#include "worker/base/extend_pixels.hpp"
#include "worker/mesh/triangle_pixels.hpp"

namespace divemesh::color {
namespace {

constexpr int kShrink = 2;
// The reach of the mean of the cosine, in pixels of the small image: normals are noisy from vertex
// to vertex, which are a few pixels apart.
constexpr int kReach_px = 4;
constexpr int kTap_px = 2;

using InverseAndCosine = cv::Vec2f;

bool is_same_surface(float inverse, float other) {
    return std::abs(inverse - other) < kMaxDepthStep * std::max(inverse, other);
}

// Returns the normal of a triangle where its corners have these weights.
Eigen::Vector3f normal_at(const types::Mesh& mesh,
                          std::size_t face,
                          const Eigen::Vector3f& weights) {
    const auto& [a, b, c] = mesh.triangles[face];
    if (mesh.normals.size() == mesh.vertices.size())
        return weights.x() * mesh.normals[a] + weights.y() * mesh.normals[b] +
               weights.z() * mesh.normals[c];
    return (mesh.vertices[b] - mesh.vertices[a]).cross(mesh.vertices[c] - mesh.vertices[a]);
}

// Draws the nearest surface; inverse depth 0 where there is none.
cv::Mat draw(const SeenSurface& surface, const mesh::ImageCamera& camera) {
    const Eigen::Matrix3f R_world_cam = camera.T_cam_world.linear().transpose();
    cv::Mat drawn = cv::Mat::zeros(camera.rows, camera.columns, CV_32FC2);
    for (const mesh::TriangleRun& run : surface.runs_in_sight(camera))
        for (std::size_t face = run.begin; face < run.end; ++face) {
            const mesh::PixelTriangle corners = texture::project_face(surface.mesh, camera, face);
            if (!texture::is_in_front(corners)) continue;
            mesh::for_each_pixel(
                corners,
                camera.rows,
                camera.columns,
                [&](int row, int column, const Eigen::Vector3f& weights, float inverse_depth) {
                    auto& pixel = drawn.at<InverseAndCosine>(row, column);
                    if (inverse_depth <= pixel[0]) return;
                    const Eigen::Vector3f ray = R_world_cam * ray_of(camera, row, column);
                    const Eigen::Vector3f normal = normal_at(surface.mesh, face, weights);
                    const float lengths = std::max(1e-12F, normal.norm() * ray.norm());
                    pixel = {inverse_depth,
                             std::max(kMinCosine, std::abs(normal.dot(ray)) / lengths)};
                });
        }
    return drawn;
}

// Returns the mean cosine around a pixel, of the same surface.
float smooth_cosine(const cv::Mat& drawn, int row, int column) {
    const float inverse = drawn.at<InverseAndCosine>(row, column)[0];
    float sum = 0.0F;
    float num = 0.0F;
    for (int down = -kReach_px; down <= kReach_px; down += kTap_px)
        for (int right = -kReach_px; right <= kReach_px; right += kTap_px) {
            const int y = row + down;
            const int x = column + right;
            if (y < 0 || x < 0 || y >= drawn.rows || x >= drawn.cols) continue;
            const auto& other = drawn.at<InverseAndCosine>(y, x);
            if (!is_same_surface(inverse, other[0])) continue;
            sum += other[1];
            num += 1.0F;
        }
    return sum / num;  // the pixel itself is one of them
}

}  // namespace

SurfaceImages::SurfaceImages(const SeenSurface& surface, const types::Keyframe& keyframe)
    : camera_(surface.camera_of(keyframe)) {
    const int columns = (camera_.columns + kShrink - 1) / kShrink;
    scale_ = static_cast<float>(columns) / static_cast<float>(std::max(1, camera_.columns));
    const int rows = static_cast<int>(std::ceil(static_cast<float>(camera_.rows) * scale_));
    const cv::Mat drawn = draw(surface, {surface.rig, keyframe.T_world_cam, columns, rows});
    cv::Mat is_empty(drawn.size(), CV_8U, cv::Scalar(255));
    cv::Mat smooth = drawn.clone();
    bool any = false;
    for (int row = 0; row < drawn.rows; ++row)
        for (int column = 0; column < drawn.cols; ++column) {
            if (drawn.at<InverseAndCosine>(row, column)[0] <= 0.0F) continue;
            any = true;
            is_empty.at<std::uint8_t>(row, column) = 0;
            smooth.at<InverseAndCosine>(row, column)[1] = smooth_cosine(drawn, row, column);
        }
    if (!any) return;
    base::extend_pixels<InverseAndCosine>(is_empty, smooth);
    surface_ = smooth;
}

SurfaceImages::Pixel SurfaceImages::at(int row, int column) const {
    if (surface_.empty()) return {};
    const auto place = [&](int of_image, int size) {
        return std::clamp((static_cast<float>(of_image) + 0.5F) * scale_ - 0.5F,
                          0.0F,
                          static_cast<float>(size - 1));
    };
    const float y = place(row, surface_.rows);
    const float x = place(column, surface_.cols);
    const int top = static_cast<int>(y);
    const int left = static_cast<int>(x);
    const int bottom = std::min(top + 1, surface_.rows - 1);
    const int right = std::min(left + 1, surface_.cols - 1);
    const float down = y - static_cast<float>(top);
    const float across = x - static_cast<float>(left);
    const auto& a = surface_.at<InverseAndCosine>(top, left);
    const auto& b = surface_.at<InverseAndCosine>(top, right);
    const auto& c = surface_.at<InverseAndCosine>(bottom, left);
    const auto& d = surface_.at<InverseAndCosine>(bottom, right);
    InverseAndCosine mean =
        surface_.at<InverseAndCosine>(down < 0.5F ? top : bottom, across < 0.5F ? left : right);
    if (is_same_surface(std::min({a[0], b[0], c[0], d[0]}), std::max({a[0], b[0], c[0], d[0]})))
        mean = (1.0F - down) * ((1.0F - across) * a + across * b) +
               down * ((1.0F - across) * c + across * d);
    return {ray_of(camera_, row, column).norm() / mean[0], mean[1]};
}

}  // namespace divemesh::color
