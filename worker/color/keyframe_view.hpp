#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <optional>
#include <vector>

#include "worker/color/linear_light.hpp"
#include "worker/mesh/image_camera.hpp"
#include "worker/mesh/triangle_runs.hpp"
#include "worker/texture/depth_buffer.hpp"
#include "worker/types/keyframe.hpp"
#include "worker/types/mesh.hpp"
#include "worker/types/rectified_rig.hpp"

namespace divemesh::color {

// A surface and what finds the parts of it that a camera sees. Refers to the mesh.
struct SeenSurface {
    const types::Mesh& mesh;
    const types::RectifiedRig& rig;
    std::vector<mesh::TriangleRun> runs;

    SeenSurface(const types::Mesh& of, const types::RectifiedRig& by)
        : mesh(of), rig(by), runs(mesh::triangle_runs(of)) {}

    // Returns those of the runs that the camera may see.
    std::vector<mesh::TriangleRun> runs_in_sight(const mesh::ImageCamera& camera) const;
    mesh::ImageCamera camera_of(const types::Keyframe& keyframe) const;
};

// Returns the squared distance of a pixel from the principal point, 1 in the farthest corner.
float eccentricity_of(const mesh::ImageCamera& camera, float u_px, float v_px);

// Returns the ray of a pixel with z = 1, in the frame of the camera.
Eigen::Vector3f ray_of(const mesh::ImageCamera& camera, int row, int column);

// The flattest angle at which surface is used, 75 degrees from the normal: beyond it an error of
// the pose moves the pixel too far over it.
inline constexpr float kMinCosine = 0.25F;
// How much depth may change within one surface, as a share of it: what a slanted surface does over
// a few pixels; a silhouette more.
inline constexpr float kMaxDepthStep = 0.04F;

// What a keyframe shows at a point of the surface.
struct SeenPoint {
    float range_m = 0.0F;
    float eccentricity = 0.0F;
    float cosine = 1.0F;  // of the angle between the normal and the direction to the camera
    Rgb rgb = {};         // linear light, mean over a window
};

// The image of a keyframe with the surface before it.
class KeyframeView {
public:
    // `images`: of KeyframeStore::read(); its depth may be empty.
    KeyframeView(const SeenSurface& surface,
                 const types::Keyframe& keyframe,
                 const types::KeyframeImages& images,
                 int num_threads);

    // Returns what the image shows at a point of the surface with that normal: nullopt if the point
    // is out of sight, hidden, seen at a grazing angle, beside a silhouette or saturated, or if the
    // measured depth is of something else, such as a fish.
    std::optional<SeenPoint> seen_at(const Eigen::Vector3f& p_world,
                                     const Eigen::Vector3f& normal_world,
                                     int window_px) const;

private:
    bool shows_surface(int row, int column, float depth_m, int reach_px) const;
    bool contradicts(int row, int column, float depth_m) const;
    std::optional<Rgb> mean_light(int row, int column, int reach_px) const;

    const types::KeyframeImages& images_;
    float focal_baseline_;
    mesh::ImageCamera camera_;
    Eigen::Vector3f position_world_;
    texture::DepthBuffer depth_;
};

}  // namespace divemesh::color
