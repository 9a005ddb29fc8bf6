#include "worker/simulator/draw_rig.hpp"

#include "worker/base/angle.hpp"
#include "worker/base/hashed_random.hpp"

namespace divemesh::simulator {
namespace {

Eigen::Matrix3d small_rotation(base::RandomRow& random, double max_deg) {
    const double x = random.uniform(-max_deg, max_deg) * base::kRadPerDeg;
    const double y = random.uniform(-max_deg, max_deg) * base::kRadPerDeg;
    const double z = random.uniform(-max_deg, max_deg) * base::kRadPerDeg;
    return (Eigen::AngleAxisd(x, Eigen::Vector3d::UnitX()) *
            Eigen::AngleAxisd(y, Eigen::Vector3d::UnitY()) *
            Eigen::AngleAxisd(z, Eigen::Vector3d::UnitZ()))
        .toRotationMatrix();
}

types::Camera draw_camera(int width_px, int height_px, double focal_px, base::RandomRow& random) {
    types::Camera camera;
    const double size = width_px / 640.0;
    camera.width_px = width_px;
    camera.height_px = height_px;
    camera.fx_px = focal_px * size * random.uniform(0.995, 1.005);
    camera.fy_px = camera.fx_px * random.uniform(0.998, 1.001);
    camera.cx_px = 0.5 * (width_px - 1) + size * random.uniform(-6.0, 6.0);
    camera.cy_px = 0.5 * (height_px - 1) + size * random.uniform(-6.0, 6.0);
    camera.distortion = types::Distortion::RadialTangential;
    camera.distortion_coefficients = {random.uniform(-0.16, -0.09),
                                      random.uniform(0.02, 0.04),
                                      random.uniform(-5e-4, 5e-4),
                                      random.uniform(-5e-4, 5e-4)};
    return camera;
}

// Returns coefficients as real lenses of a model have them: they bend the image inwards, by a tenth
// at its corners.
types::LensCoefficients draw_coefficients(types::Distortion lens, base::RandomRow& random) {
    const auto tangential = [&] { return random.uniform(-5e-4, 5e-4); };
    types::LensCoefficients k = {};
    switch (lens) {
        case types::Distortion::None:
        case types::Distortion::RadialTangential: break;
        case types::Distortion::Equidistant:
            for (std::size_t i = 0; i < 4; ++i) k[i] = random.uniform(-0.02, 0.02);
            break;
        case types::Distortion::Rational:
            k = {random.uniform(0.20, 0.30), random.uniform(0.02, 0.05)};
            k[2] = tangential();
            k[3] = tangential();
            k[4] = random.uniform(0.001, 0.003);
            k[5] = random.uniform(0.35, 0.40);
            k[6] = random.uniform(0.05, 0.08);
            k[7] = random.uniform(0.002, 0.004);
            break;
        case types::Distortion::Omnidirectional:
            k = {random.uniform(1.2, 1.6), random.uniform(-0.1, 0.1), random.uniform(-0.05, 0.05)};
            k[3] = tangential();
            k[4] = tangential();
            break;
        case types::Distortion::DoubleSphere:
            k = {random.uniform(-0.25, -0.15), random.uniform(0.54, 0.60)};
            break;
        case types::Distortion::ExtendedUnified:
            k = {random.uniform(0.55, 0.65), random.uniform(1.0, 1.2)};
            break;
    }
    return k;
}

}  // namespace

types::Rig draw_rig(int width_px, int height_px, std::uint64_t seed, types::Distortion lens) {
    base::RandomRow random(base::hash64(seed, 0x726967ULL));
    types::Rig rig;
    const double focal_px = random.uniform(450.0, 540.0);
    rig.cam0 = draw_camera(width_px, height_px, focal_px, random);
    rig.cam1 = draw_camera(width_px, height_px, focal_px, random);
    if (lens != types::Distortion::RadialTangential) {
        base::RandomRow lens_random(base::hash64(seed, 0x6c656e73ULL));
        for (types::Camera* camera : {&rig.cam0, &rig.cam1}) {
            camera->distortion = lens;
            camera->distortion_coefficients = draw_coefficients(lens, lens_random);
        }
    }
    Eigen::Matrix3d R_forward_cam;  // camera: x right, y down, z forward; body: forward, left, up
    R_forward_cam << 0, 0, 1, -1, 0, 0, 0, -1, 0;
    rig.T_imu_cam0.linear() = small_rotation(random, 3.0) * R_forward_cam;
    rig.T_imu_cam0.translation() = Eigen::Vector3d{
        random.uniform(0.03, 0.09), random.uniform(0.03, 0.08), random.uniform(-0.05, 0.02)};
    Eigen::Isometry3d T_cam0_cam1 = Eigen::Isometry3d::Identity();
    T_cam0_cam1.linear() = small_rotation(random, 0.45);
    T_cam0_cam1.translation() = Eigen::Vector3d{
        random.uniform(0.10, 0.15), random.uniform(-0.002, 0.002), random.uniform(-0.002, 0.002)};
    rig.T_imu_cam1 = rig.T_imu_cam0 * T_cam0_cam1;
    rig.imu_noise = types::ImuNoise{.gyroscope_noise_density = 1.7e-4,
                                    .gyroscope_random_walk = 2.0e-5,
                                    .accelerometer_noise_density = 2.0e-3,
                                    .accelerometer_random_walk = 3.0e-4};
    return rig;
}

}  // namespace divemesh::simulator
