#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <vector>

namespace divemesh::evaluation {

// Distance from a point to the nearest of the cameras along a path, exactly. Cameras that follow
// one another are near one another: boxes around runs of them are asked first.
class NearestCamera {
public:
    explicit NearestCamera(std::vector<Eigen::Vector3f> positions);

    // Infinity when there is no camera.
    float distance_m(const Eigen::Vector3f& point) const;

private:
    std::vector<Eigen::Vector3f> positions_;
    std::vector<Eigen::AlignedBox3f> boxes_;  // of kRun positions each
};

}  // namespace divemesh::evaluation
