#include "worker/board_calibration/calibrate_rig.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "schemas/error.hpp"
#include "tests/worker/board_calibration/synthetic_boards.hpp"
#include "worker/board_calibration/calibrate_recording.hpp"
#include "worker/camera/projection.hpp"
#include "worker/dive/calibration.hpp"
#include "worker/dive/lens_yaml.hpp"
#include "worker/dive/sensor_yaml_text.hpp"

namespace divemesh::board_calibration {
namespace {

struct Draw {
    boards::Board board = known_checkerboard();
    RigParameters truth;
    std::vector<boards::BoardView> views;
    RigEstimate estimate;
};

Draw draw(types::Distortion distortion,
          std::uint64_t seed,
          double sigma_px,
          std::optional<types::Distortion> model) {
    std::mt19937_64 random(seed);
    Draw drawn;
    drawn.truth = known_rig(distortion);
    drawn.views = drawn_views(
        drawn.truth, drawn.board, drawn_poses(drawn.board, 80, random), sigma_px, random);
    drawn.estimate = calibrate_rig(drawn.board, drawn.views, {1280, 960}, {1280, 960}, model, {});
    return drawn;
}

double baseline_m(const RigParameters& rig) {
    return isometry_of(rig.T_cam1_cam0).translation().norm();
}

// Returns the largest distance of where two cameras show the rays of an image.
double max_distance_px(const types::Camera& camera, const types::Camera& other) {
    double max_px = 0.0;
    for (const Eigen::Vector3d& ray : rays_over(camera))
        max_px =
            std::max(max_px, (*camera::project(camera, ray) - *camera::project(other, ray)).norm());
    return max_px;
}

// Returns what sensor.yaml of a camera is read as.
std::optional<types::Camera> read_back(const types::Camera& camera) {
    dive::SensorYaml yaml;
    yaml.T_body_sensor = Eigen::Matrix4d::Identity();
    yaml.resolution = {static_cast<double>(camera.width_px), static_cast<double>(camera.height_px)};
    dive::state_lens(camera, yaml);
    dive::FindingLog findings;
    const std::string text = dive::camera_yaml_text(yaml, {"test"});
    const auto read = dive::parse_sensor_yaml(text, "sensor.yaml", findings);
    const auto calibrated = dive::calibrated_camera(*read, "sensor.yaml", findings);
    return calibrated ? std::optional(calibrated->camera) : std::nullopt;
}

TEST(CalibrateRigTest, WithoutNoiseFindsTheRigExactly) {
    for (const auto distortion : {types::Distortion::RadialTangential,
                                  types::Distortion::Equidistant,
                                  types::Distortion::DoubleSphere,
                                  types::Distortion::ExtendedUnified}) {
        const Draw drawn = draw(distortion, 1, 0.0, distortion);
        ASSERT_EQ(drawn.estimate.failure, "");
        const RigVector error = drawn.estimate.rig.vector() - drawn.truth.vector();
        EXPECT_LT(error.cwiseAbs().maxCoeff(), 1e-4) << error.transpose();
    }
}

// Corners determine their coefficients only together with the priors.
TEST(CalibrateRigTest, WithLittleNoiseFindsTheRaysOfModelsWithPriors) {
    for (const auto distortion :
         {types::Distortion::Rational, types::Distortion::Omnidirectional}) {
        const Draw drawn = draw(distortion, 1, 0.01, distortion);
        ASSERT_EQ(drawn.estimate.failure, "");
        EXPECT_LT(max_distance_px(drawn.truth.cam0(), drawn.estimate.rig.cam0()), 0.2);
        EXPECT_LT(max_distance_px(drawn.truth.cam1(), drawn.estimate.rig.cam1()), 0.2);
        EXPECT_NEAR(baseline_m(drawn.estimate.rig) / baseline_m(drawn.truth), 1.0, 5e-5);
    }
}

TEST(CalibrateRigTest, FindsADoubleSphereOfPositiveXi) {
    std::mt19937_64 random(1);
    const boards::Board board = known_checkerboard();
    RigParameters truth = known_rig(types::Distortion::DoubleSphere);
    truth.lens1[4] = 0.3;
    truth.lens1[5] = 0.62;
    const auto views = drawn_views(truth, board, drawn_poses(board, 80, random), 0.0, random);
    const RigEstimate estimate =
        calibrate_rig(board, views, {1280, 960}, {1280, 960}, types::Distortion::DoubleSphere, {});
    ASSERT_EQ(estimate.failure, "");
    EXPECT_LT((estimate.rig.vector() - truth.vector()).cwiseAbs().maxCoeff(), 1e-3);
}

TEST(CalibrateRigTest, EveryModelComesBackFromSensorYaml) {
    int num_models = 0;
    for (const camera::LensModel& model : camera::lens_models()) {
        if (model.num_coefficients == 0) continue;
        const Draw drawn = draw(model.distortion, 6, 0.1, model.distortion);
        ASSERT_EQ(drawn.estimate.failure, "") << model.name;
        const types::Camera camera = drawn.estimate.rig.cam0();
        const auto read = read_back(camera);
        ASSERT_TRUE(read) << model.name;
        EXPECT_EQ(read->distortion, model.distortion);
        EXPECT_EQ(read->distortion_coefficients, camera.distortion_coefficients) << model.name;
        EXPECT_LT(max_distance_px(camera, *read), 1e-9) << model.name;
        EXPECT_EQ(std::ssize(drawn.estimate.rig.names()), drawn.estimate.rig.size());
        ++num_models;
    }
    EXPECT_EQ(num_models, 6);
}

// A lens that bends outwards: alpha of 0, which bends nothing, is the nearest to it.
TEST(CalibrateRigTest, SaysWhichCoefficientALensModelHasNotGot) {
    std::mt19937_64 random(7);
    const boards::Board board = known_checkerboard();
    RigParameters truth = known_rig(types::Distortion::RadialTangential);
    truth.lens0[4] = truth.lens1[4] = 0.1;
    const auto views = drawn_views(truth, board, drawn_poses(board, 80, random), 0.1, random);
    const RigEstimate estimate = calibrate_rig(
        board, views, {1280, 960}, {1280, 960}, types::Distortion::ExtendedUnified, {});
    EXPECT_NE(estimate.failure.find("alpha of cam0 ends at 0"), std::string::npos)
        << estimate.failure;
}

TEST(CalibrateRigTest, AnUnknownModelNamesTheKnownOnes) {
    EXPECT_EQ(model_from_string("auto"), std::nullopt);
    EXPECT_EQ(model_from_string("double-sphere"), types::Distortion::DoubleSphere);
    try {
        model_from_string("fov");
        FAIL() << "fov is no lens model";
    } catch (const Error& error) {
        EXPECT_STREQ(error.what(),
                     "unknown lens model: fov (known: auto, radial-tangential, equidistant, "
                     "rational, omnidirectional, double-sphere, extended-unified)");
    }
}

TEST(CalibrateRigTest, ChoosesTheModelOfTheLens) {
    for (const auto distortion :
         {types::Distortion::RadialTangential, types::Distortion::Equidistant}) {
        const Draw drawn = draw(distortion, 2, 0.1, std::nullopt);
        ASSERT_EQ(drawn.estimate.failure, "");
        EXPECT_EQ(drawn.estimate.rig.kind0.distortion, distortion);
        ASSERT_EQ(drawn.estimate.models.size(), 2U);
        EXPECT_LT(drawn.estimate.models[0].left_rms_px, drawn.estimate.models[1].left_rms_px);
        EXPECT_NEAR(drawn.estimate.sigma_px, 0.1, 0.005);
    }
}

TEST(CalibrateRigTest, NamesViewsThatHarmAndLeavesThemOut) {
    std::mt19937_64 random(3);
    const boards::Board board = known_checkerboard();
    const RigParameters truth = known_rig(types::Distortion::RadialTangential);
    auto views = drawn_views(truth, board, drawn_poses(board, 80, random), 0.1, random);
    std::vector<std::int64_t> harmed;
    for (boards::BoardView& view : views) {
        if (view.left.empty() || view.right.empty() || harmed.size() == 3) continue;
        for (auto& corner : view.right) corner.pixel.x() += 6.0;  // the board moved in between
        harmed.push_back(view.timestamp_ns);
    }
    const RigEstimate estimate = calibrate_rig(
        board, views, {1280, 960}, {1280, 960}, types::Distortion::RadialTangential, {});
    ASSERT_EQ(estimate.failure, "");
    std::vector<std::int64_t> named;
    for (const ViewLeftOut& view : estimate.left_out) named.push_back(view.timestamp_ns);
    std::sort(named.begin(), named.end());
    EXPECT_EQ(named, harmed);
    EXPECT_NEAR(baseline_m(estimate.rig) / baseline_m(truth), 1.0, 5e-4);
}

TEST(CalibrateRigTest, LeavesOutSingleCornersThatAreWrong) {
    std::mt19937_64 random(4);
    const boards::Board board = known_checkerboard();
    const RigParameters truth = known_rig(types::Distortion::RadialTangential);
    auto views = drawn_views(truth, board, drawn_poses(board, 80, random), 0.1, random);
    int num_moved = 0;
    for (boards::BoardView& view : views)
        if (!view.left.empty() && ++num_moved % 4 == 0) view.left[5].pixel.y() += 1.5;
    const RigEstimate estimate = calibrate_rig(
        board, views, {1280, 960}, {1280, 960}, types::Distortion::RadialTangential, {});
    ASSERT_EQ(estimate.failure, "");
    EXPECT_EQ(estimate.num_corners_left_out, num_moved / 4);
}

TEST(CalibrateRigTest, SaysWhyTooFewViewsAreNotEnough) {
    std::mt19937_64 random(5);
    const boards::Board board = known_checkerboard();
    const auto views = drawn_views(known_rig(types::Distortion::RadialTangential),
                                   board,
                                   drawn_poses(board, 2, random),
                                   0.1,
                                   random);
    const RigEstimate estimate =
        calibrate_rig(board, views, {1280, 960}, {1280, 960}, std::nullopt, {});
    EXPECT_NE(estimate.failure.find("fewer than 3 pairs"), std::string::npos) << estimate.failure;
    EXPECT_NE(calibrate_rig(board, {}, {1280, 960}, {1280, 960}, std::nullopt, {}).failure, "");
}

}  // namespace
}  // namespace divemesh::board_calibration
