#include "worker/camera/rerectifier.hpp"

#include <gtest/gtest.h>

#include "worker/camera/projection.hpp"
#include "worker/camera/rectifier.hpp"

namespace divemesh::camera {
namespace {

// Returns a rig whose cameras are half a degree apart and have this `k1`.
types::Rig rig_with(double k1) {
    types::Rig rig;
    rig.cam0 = {640, 480, 498.0, 497.0, 322.0, 238.0};
    rig.cam0.distortion_coefficients = {k1, 0.03, 4e-4, -3e-4};
    rig.cam1 = rig.cam0;
    rig.cam1.cx_px = 318.0;
    rig.T_imu_cam1.translation() = Eigen::Vector3d(0.12, 0.001, -0.001);
    rig.T_imu_cam1.linear() =
        Eigen::AngleAxisd(0.009, Eigen::Vector3d(0.3, 0.8, 0.5).normalized()).toRotationMatrix();
    return rig;
}

constexpr double kStated = -0.108;
constexpr double kTrue = -0.12;

// Returns where a point recorded by the true lenses appears in a pair rectified with the stated
// ones.
Eigen::Vector3d measured_px(const types::RectifiedRig& rectified, const Eigen::Vector3d& p_cam) {
    const auto stated = rectified_lenses(rig_with(kStated));
    const auto real = rectified_lenses(rig_with(kTrue));
    const Eigen::Vector3d p_right = p_cam - Eigen::Vector3d(rectified.baseline_m, 0.0, 0.0);
    const Eigen::Vector2d left = stated[0].rectified_px(
        rectified, *project(real[0].camera, real[0].R_camera_rectified * p_cam));
    const Eigen::Vector2d right = stated[1].rectified_px(
        rectified, *project(real[1].camera, real[1].R_camera_rectified * p_right));
    return {left.x(), left.y(), left.x() - right.x()};
}

std::array<types::LensChange, 2> change_of_k1(double change) {
    types::LensChange lens;
    lens.values[3] = change;
    return {lens, lens};
}

TEST(RerectifierTest, PutsObservationsWhereTheTrueLensesWouldHaveShownThem) {
    const types::RectifiedRig rectified = Rectifier(rig_with(kStated)).rig();
    const Rerectifier rerectifier(rig_with(kStated), rectified, change_of_k1(kTrue - kStated));
    double max_error_px = 0.0;
    for (const Eigen::Vector3d& p_cam : {Eigen::Vector3d(0.9, 0.7, 1.5),
                                         Eigen::Vector3d(-0.4, 0.2, 1.1),
                                         Eigen::Vector3d(0.8, -0.9, 2.0)}) {
        const Eigen::Vector2d left = rectified.pixel(p_cam);
        const Eigen::Vector3d ideal(left.x(), left.y(), rectified.disparity_px(p_cam.z()));
        const Eigen::Vector3d measured = measured_px(rectified, p_cam);
        max_error_px = std::max(max_error_px, (measured - ideal).norm());
        EXPECT_LT((rerectifier.moved(measured) - ideal).norm(), 0.05);
    }
    EXPECT_GT(max_error_px, 1.0);
}

TEST(RerectifierTest, MovesAKeyframesDepthAsItMovesObservations) {
    const types::RectifiedRig rectified = Rectifier(rig_with(kStated)).rig();
    const Rerectifier rerectifier(rig_with(kStated), rectified, change_of_k1(kTrue - kStated));
    types::KeyframeImages images;
    images.left_color = cv::Mat::zeros(480, 640, CV_8UC3);
    images.depth.disparity_px = cv::Mat(480, 640, CV_32F, cv::Scalar(40.0));
    images.depth.sigma_disparity_px = cv::Mat(480, 640, CV_32F, cv::Scalar(0.2));

    const types::KeyframeImages moved = KeyframeRerectifier(rectified, rerectifier).moved(images);

    for (const Eigen::Vector2d& old :
         {Eigen::Vector2d(100.0, 60.0), Eigen::Vector2d(560.0, 400.0)}) {
        const Eigen::Vector3d expected = rerectifier.moved(Eigen::Vector3d(old.x(), old.y(), 40.0));
        const auto disparity =
            moved.depth.disparity_px.at<float>(static_cast<int>(std::lround(expected.y())),
                                               static_cast<int>(std::lround(expected.x())));
        EXPECT_NEAR(disparity, expected.z(), 0.05);
    }
}

// With nearest-neighbour sampling a slope would become a staircase.
TEST(RerectifierTest, LeavesASlopeSmooth) {
    const types::RectifiedRig rectified = Rectifier(rig_with(kStated)).rig();
    const Rerectifier rerectifier(rig_with(kStated), rectified, change_of_k1(kTrue - kStated));
    const auto slope_px = [](double u, double v) { return 30.0 + 0.05 * u + 0.1 * v; };
    types::KeyframeImages images;
    images.left_color = cv::Mat::zeros(480, 640, CV_8UC3);
    images.depth.disparity_px = cv::Mat(480, 640, CV_32F);
    for (int v = 0; v < 480; ++v)
        for (int u = 0; u < 640; ++u)
            images.depth.disparity_px.at<float>(v, u) = static_cast<float>(slope_px(u, v));
    images.depth.sigma_disparity_px = cv::Mat(480, 640, CV_32F, cv::Scalar(0.2));

    const types::KeyframeImages moved = KeyframeRerectifier(rectified, rerectifier).moved(images);

    double max_error_px = 0.0;
    for (int v = 100; v < 400; v += 7)
        for (int u = 150; u < 500; u += 7) {
            Eigen::Vector2d old(u, v);  // the pixel that moves to u, v
            for (int i = 0; i < 10; ++i) {
                const Eigen::Vector3d there =
                    rerectifier.moved({old.x(), old.y(), slope_px(old.x(), old.y())});
                old -= there.head<2>() - Eigen::Vector2d(u, v);
            }
            const double expected_px =
                rerectifier.moved({old.x(), old.y(), slope_px(old.x(), old.y())}).z();
            max_error_px = std::max(
                max_error_px, std::abs(moved.depth.disparity_px.at<float>(v, u) - expected_px));
        }
    EXPECT_LT(max_error_px, 0.01);
}

TEST(ShiftOfChangeTest, IsWhereTheChangedLensShowsARay) {
    const types::RectifiedRig rectified = Rectifier(rig_with(kStated)).rig();
    const auto lenses = rectified_lenses(rig_with(kStated));
    const Eigen::Vector2d pixel(420.0, 110.0);
    types::LensChange change;
    change.values << 1e-4, 0.03, -0.02, 1e-4, -2e-4;
    RectifiedLens changed = lenses[0];
    changed.camera = changed_camera(changed.camera, change);

    const Eigen::Vector2d shown =
        lenses[0].rectified_px(rectified, changed.recorded_px(rectified, pixel));
    const Eigen::Vector2d shift = shift_of_change(rectified, lenses[0], pixel) * change.values;

    EXPECT_GT(shift.norm(), 0.02);
    EXPECT_LT((pixel + shift - shown).norm(), 1e-3);
}

}  // namespace
}  // namespace divemesh::camera
