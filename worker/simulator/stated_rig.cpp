#include "worker/simulator/stated_rig.hpp"

#include <cmath>

#include "worker/base/angle.hpp"
#include "worker/base/hashed_random.hpp"
#include "worker/base/rotation_vector.hpp"

namespace divemesh::simulator {
namespace {

// Standard deviations of a typical calibration under water.
constexpr double kFocal = 0.0015;   // relative
constexpr double kCenter_px = 1.0;  // of a camera that is 640 px wide
constexpr double kCenterWidth_px = 640.0;
constexpr double kK1 = 0.03;  // relative
constexpr double kStereo_rad = 0.03 * base::kRadPerDeg;
constexpr double kBaseline = 0.002;  // relative
constexpr double kImu_rad = 0.25 * base::kRadPerDeg;
constexpr double kImuClock_ns = 4e6;

// Draws of one seed, scaled; each call draws again.
class Errors {
public:
    Errors(double times, std::uint64_t seed)
        : times_(times), random_(base::hash64(seed, 0x63616c6962ULL)) {}

    double draw(double sigma) { return times_ * sigma * random_.gaussian(); }
    Eigen::Isometry3d draw_rotation(double sigma_rad) {
        const double x = draw(sigma_rad);
        const double y = draw(sigma_rad);
        const Eigen::Vector3d rotation(x, y, draw(sigma_rad));
        Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
        T.rotate(base::rotation_from_vector(rotation));
        return T;
    }

private:
    double times_;
    base::RandomRow random_;
};

void misstate(types::Camera& camera, Errors& errors) {
    const double focal = 1.0 + errors.draw(kFocal);
    camera.fx_px *= focal;
    camera.fy_px *= focal;
    const double center_px = kCenter_px * camera.width_px / kCenterWidth_px;
    camera.cx_px += errors.draw(center_px);
    camera.cy_px += errors.draw(center_px);
    camera.distortion_coefficients[0] *= 1.0 + errors.draw(kK1);
}

}  // namespace

StatedRig draw_calibration_error(const types::Rig& rig, double times, std::uint64_t seed) {
    Errors errors(times, seed);
    StatedRig stated{.rig = rig};
    misstate(stated.rig.cam0, errors);
    misstate(stated.rig.cam1, errors);
    Eigen::Isometry3d T_cam0_cam1 = rig.T_cam1_cam0().inverse() * errors.draw_rotation(kStereo_rad);
    T_cam0_cam1.translation() *= 1.0 + errors.draw(kBaseline);
    stated.rig.T_imu_cam0 = rig.T_imu_cam0 * errors.draw_rotation(kImu_rad);
    stated.rig.T_imu_cam1 = stated.rig.T_imu_cam0 * T_cam0_cam1;
    stated.imu_clock_offset_ns = std::llround(errors.draw(kImuClock_ns));
    return stated;
}

types::Rig pitch_right_camera(types::Rig rig, double misalignment_px) {
    rig.T_imu_cam1.rotate(
        Eigen::AngleAxisd(std::atan(misalignment_px / rig.cam1.fy_px), Eigen::Vector3d::UnitX()));
    return rig;
}

}  // namespace divemesh::simulator
