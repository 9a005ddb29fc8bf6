#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <vector>

namespace divemesh::evaluation {

// Returns exact distances from a point to the nearest camera of a path. Consecutive cameras are
// close to each other, so bounding boxes of runs of them are tested first.
class NearestCamera {
public:
    explicit NearestCamera(std::vector<Eigen::Vector3f> positions);

    // Returns infinity if there are no cameras.
    float distance_m(const Eigen::Vector3f& point) const;

private:
    std::vector<Eigen::Vector3f> positions_;
    std::vector<Eigen::AlignedBox3f> boxes_;  // of kRun positions each
};

}  // namespace divemesh::evaluation
