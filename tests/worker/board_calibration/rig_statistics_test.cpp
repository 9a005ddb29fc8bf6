#include <gtest/gtest.h>

#include <cmath>

#include "tests/worker/board_calibration/synthetic_boards.hpp"
#include "worker/board_calibration/calibrate_rig.hpp"
#include "worker/camera/projection.hpp"

namespace divemesh::board_calibration {
namespace {

constexpr int kNumDraws = 20;

double baseline_m(const RigParameters& rig) {
    return isometry_of(rig.T_cam1_cam0).translation().norm();
}

// How often something is within three of its standard deviations.
struct Within {
    int num = 0;
    int num_within = 0;
    double squares = 0.0;

    void add(double sigmas) {
        ++num;
        num_within += std::abs(sigmas) <= 3.0 ? 1 : 0;
        squares += sigmas * sigmas;
    }
    double rms() const { return std::sqrt(squares / num); }
};

// Adds where the left camera shows the rays of its image.
void add_pixels(const RigParameters& truth, const RigEstimate& estimate, Within& within) {
    for (const Eigen::Vector3d& ray : rays_over(truth.cam0())) {
        Eigen::MatrixXd J(2, truth.size());
        for (int i = 0; i < truth.size(); ++i) {
            RigVector step = RigVector::Zero(truth.size());
            step[i] = 0.01 * std::sqrt(estimate.covariance(i, i));
            J.col(i) = (*camera::project(estimate.rig.changed_by(step).cam0(), ray) -
                        *camera::project(estimate.rig.changed_by(-step).cam0(), ray)) /
                       (2.0 * step[i]);
        }
        const Eigen::Vector2d variance = (J * estimate.covariance * J.transpose()).diagonal();
        const Eigen::Vector2d error =
            *camera::project(estimate.rig.cam0(), ray) - *camera::project(truth.cam0(), ray);
        for (int i = 0; i < 2; ++i) within.add(error[i] / std::sqrt(variance[i]));
    }
}

// Over many draws of noise and poses parameters and pixels are within three of their standard
// deviations in at least 95 %, and the scale is right.
void expect_honest(types::Distortion distortion) {
    const boards::Board board = known_checkerboard();
    const RigParameters truth = known_rig(distortion);
    Within parameters;
    Within pixels;
    double worst_scale = 0.0;
    for (int seed = 0; seed < kNumDraws; ++seed) {
        std::mt19937_64 random(static_cast<std::uint64_t>(100 + seed));
        const double sigma_px = 0.1 + 0.2 * seed / (kNumDraws - 1);
        const auto views =
            drawn_views(truth, board, drawn_poses(board, 90, random), sigma_px, random);
        const RigEstimate estimate =
            calibrate_rig(board, views, {1280, 960}, {1280, 960}, distortion, {});
        ASSERT_EQ(estimate.failure, "");
        EXPECT_NEAR(estimate.sigma_px / sigma_px, 1.0, 0.05);
        const RigVector error = estimate.rig.vector() - truth.vector();
        for (int i = 0; i < truth.size(); ++i)
            parameters.add(error[i] / std::sqrt(estimate.covariance(i, i)));
        add_pixels(truth, estimate, pixels);
        worst_scale =
            std::max(worst_scale, std::abs(baseline_m(estimate.rig) / baseline_m(truth) - 1.0));
    }
    EXPECT_GE(parameters.num_within, 0.95 * parameters.num);
    EXPECT_GE(pixels.num_within, 0.95 * pixels.num);
    EXPECT_LT(worst_scale, 5e-4);
    std::printf(
        "within 3 sigma: %d of %d; rms %.2f sigma; pixels %d of %d; scale off by at most %.4f %%\n",
        parameters.num_within,
        parameters.num,
        parameters.rms(),
        pixels.num_within,
        pixels.num,
        100.0 * worst_scale);
}

TEST(RigStatisticsTest, ErrorsOfARadialTangentialRigAreWhatItsCovarianceSays) {
    expect_honest(types::Distortion::RadialTangential);
}

TEST(RigStatisticsTest, ErrorsOfAFisheyeRigAreWhatItsCovarianceSays) {
    expect_honest(types::Distortion::Equidistant);
}

TEST(RigStatisticsTest, ErrorsOfARationalRigAreWhatItsCovarianceSays) {
    expect_honest(types::Distortion::Rational);
}

TEST(RigStatisticsTest, ErrorsOfAnOmnidirectionalRigAreWhatItsCovarianceSays) {
    expect_honest(types::Distortion::Omnidirectional);
}

TEST(RigStatisticsTest, ErrorsOfADoubleSphereRigAreWhatItsCovarianceSays) {
    expect_honest(types::Distortion::DoubleSphere);
}

TEST(RigStatisticsTest, ErrorsOfAnExtendedUnifiedRigAreWhatItsCovarianceSays) {
    expect_honest(types::Distortion::ExtendedUnified);
}

}  // namespace
}  // namespace divemesh::board_calibration
