#include "worker/dive/gravity_check.hpp"

#include <numbers>
#include <vector>

#include "worker/base/text.hpp"
#include "worker/stats/median.hpp"

namespace divemesh::dive {
namespace {

// Up in cam0 (x right, y down, z forward). Rigs that look ahead, down or between have y + z from
// -1.3 to -1.4, and with the sign reversed 1.3 to 1.4.
constexpr double kMinDown = 0.3;
constexpr double kMinDownAndForward = 0.85;

}  // namespace

void check_gravity_direction(const DiveContents& contents, FindingLog& findings) {
    if (contents.imu.empty() || !contents.has_rig) return;
    Eigen::Vector3d force_imu;
    for (int axis = 0; axis < 3; ++axis) {
        std::vector<double> values;
        values.reserve(contents.imu.size());
        for (const types::ImuSample& sample : contents.imu)
            values.push_back(sample.acceleration_imu[axis]);
        force_imu[axis] = stats::upper_median(std::move(values));
    }
    const Eigen::Vector3d up_cam0 =
        (contents.rig.T_imu_cam0.linear().transpose() * force_imu).normalized();
    if (!(up_cam0.y() > kMinDown && up_cam0.y() + up_cam0.z() > kMinDownAndForward)) return;
    findings.warning("gravity_upside_down",
                     "mav0/imu0/data.csv",
                     "the accelerometer says that the cameras are upside down: up is towards the "
                     "lower edge of their images (y " +
                         base::fixed(up_cam0.y(), 2) + " in cam0's frame)",
                     "If they are not, its sign is reversed: write the specific force, which at "
                     "rest is 9.81 m/s^2 upwards. If they are, ignore this.");
}

}  // namespace divemesh::dive
