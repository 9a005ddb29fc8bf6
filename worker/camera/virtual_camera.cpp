#include "worker/camera/virtual_camera.hpp"

#include <vector>

#include "worker/camera/projection.hpp"

namespace divemesh::camera {
namespace {

constexpr int kSteps = 16;            // of the grid of pixels, in both directions
constexpr double kMinParallax = 0.0;  // the rays of one image always differ

std::vector<base::Ray> rays_of_image(const types::Camera& camera) {
    std::vector<base::Ray> rays;
    for (int row = 0; row <= kSteps; ++row)
        for (int column = 0; column <= kSteps; ++column)
            rays.push_back(sight_ray(camera,
                                     {static_cast<double>(column) / kSteps * (camera.width_px - 1),
                                      static_cast<double>(row) / kSteps * (camera.height_px - 1)}));
    return rays;
}

}  // namespace

void move_into_water(types::Camera& camera, Eigen::Isometry3d& T_body_cam, double water_index) {
    if (!camera.port) return;
    types::Port& port = *camera.port;
    if (port.water_index == 0.0) port.water_index = water_index;
    const auto origin = base::nearest_to_rays(rays_of_image(camera), kMinParallax);
    if (!origin) return;
    port.p_lens_cam -= *origin;
    T_body_cam.translate(*origin);
}

bool has_port(const types::Rig& rig) { return rig.cam0.port || rig.cam1.port; }

types::Rig with_reference_depth(types::Rig rig, double depth_m) {
    for (types::Camera* camera : {&rig.cam0, &rig.cam1})
        if (camera->port) camera->port->reference_depth_m = depth_m;
    return rig;
}

}  // namespace divemesh::camera
