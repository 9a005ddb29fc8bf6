#include "worker/evaluation/path_length.hpp"

namespace divemesh::evaluation {

double path_length_m(const types::Trajectory& trajectory) {
    double length = 0.0;
    for (std::size_t i = 1; i < trajectory.size(); ++i)
        length +=
            (trajectory[i].T_world_imu.translation() - trajectory[i - 1].T_world_imu.translation())
                .norm();
    return length;
}

}  // namespace divemesh::evaluation
