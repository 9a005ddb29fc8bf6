#include "worker/pipeline/metrics_document.hpp"

#include <gtest/gtest.h>

#include <fstream>
#include <nlohmann/json.hpp>
#include <numbers>
#include <valijson/adapters/nlohmann_json_adapter.hpp>
#include <valijson/schema.hpp>
#include <valijson/schema_parser.hpp>
#include <valijson/validator.hpp>

#include "tests/paths.hpp"
#include "tests/worker/pipeline/known_water.hpp"
#include "worker/camera/lens_model.hpp"
#include "worker/io/rig_json.hpp"

namespace divemesh::pipeline {
namespace {

using nlohmann::json;

bool is_valid(const json& document) {
    const json text =
        json::parse(std::ifstream(source_directory() / "schemas" / "metrics.schema.json"));
    valijson::Schema schema;
    valijson::SchemaParser().populateSchema(valijson::adapters::NlohmannJsonAdapter(text), schema);
    return valijson::Validator().validate(
        schema, valijson::adapters::NlohmannJsonAdapter(document), nullptr);
}

types::Rig rig() {
    types::Rig rig;
    rig.cam0 = {640, 480, 490.0, 491.0, 320.0, 240.0};
    rig.cam1 = rig.cam0;
    rig.T_imu_cam1.translation().x() = 0.12;
    return rig;
}

MetricsInput plain_dive() {
    MetricsInput input;
    input.version = "0.1.0";
    input.preset = "paper";
    input.rig = input.used_rig = rig();
    input.track.num_frames = 100;
    input.track.num_frames_tracked = 90;
    input.segments = {{100, 20, 3.5, {{0, 9'900'000'000}}}};
    input.stages = {{"track", 4.0, 8.0}, {"fuse", 1.0, 1.0}, {"evaluate", 20.0, 30.0, false, true}};
    input.findings = {{Severity::Warning, "frame_skipped", "frame 3", "cut short", ""}};
    return input;
}

markers::MarkerMetrics marker_metrics() {
    markers::MarkerMetrics metrics;
    markers::Marker marker{.id = 7, .num_views = 8, .num_keyframes = 4};
    marker.corners_world.fill(Eigen::Vector3d::Ones());
    metrics.markers = {marker};
    metrics.bars = {{.name = "a",
                     .from = {7, std::nullopt},
                     .to = {8, dive::TagCorner::TopLeft},
                     .known_m = 1.0,
                     .measured_m = 1.01,
                     .own_sigma_m = 0.002,
                     .sigma_m = 0.003,
                     .leave_one_out_error_m = 0.001,
                     .leave_one_out_sigma_m = 0.002},
                    {.name = "size of 7", .is_printed_size = true, .from = {7}, .known_m = 0.1},
                    {.name = "not seen", .known_m = 0.5}};
    metrics.scale = markers::MarkerScale{0.99, 0.001, 1, {"a"}};
    metrics.correction = markers::ScaleCorrection{true, *metrics.scale};
    metrics.findings = {{Severity::Warning, "scale_off", "markers.json", "long", "calibrate"}};
    return metrics;
}

MetricsInput dive_with_everything() {
    MetricsInput input = plain_dive();
    input.rig.imu_noise = types::ImuNoise{};
    input.track.dense = {100, 12'800, 4000, 20, 30};
    input.gravity = evaluation::GravityCheck{9.8, 0.1};
    input.optimise.path.scale_contradiction = 0.05;
    input.end_covariance_m2 = 1e-6 * Eigen::Matrix3d::Identity();
    input.evaluation.covariance = evaluation::CovarianceCheck{100, 3.1, 0.94};
    input.refined.time_offset_sigma_s = 1e-4;
    for (auto& sigmas : input.refined.lens_sigmas) sigmas.setConstant(0.01);
    input.evaluation.trajectory = evaluation::TrajectoryError{};
    input.evaluation.trajectory->segments = {{1.0, 10, 0.5, 0.6, 0.1, 0.2}};
    input.evaluation.trajectory->revisit = evaluation::RevisitError{40, 0.01, 0.02, 0.3};
    input.evaluation.causal = input.evaluation.trajectory;
    evaluation::SurfaceError surface;
    for (const double threshold : {0.005, 0.01, 0.02, 0.05})
        surface.scores.push_back({threshold, 0.5, 0.5, 0.5});
    surface.relative = evaluation::RelativeDistance{0.001, 0.004};
    surface.near_completeness = evaluation::DistanceSummary{};
    surface.share_20mm = 0.9;
    input.evaluation.surface = surface;
    input.mesh = MeshMetrics{.num_vertices = 3,
                             .num_triangles = 1,
                             .area_m2 = 0.5,
                             .coverage = {{1'000, 0.9, 0.8, 0.6}},
                             .simplification = mesh::SimplificationError{9, 0.001, 0.002},
                             .voxels = {0.01, 0.005, 0.02}};
    static const WaterColor water = known_water();
    input.color = &water;
    evaluation::KnownDistanceErrors known;
    known.distances = {{"bar", 1.0, 1.01, 8, 9}, {"rib", 2.0, std::nullopt, 0, 9}};
    known.num_measured = 1;
    input.evaluation.known_distances = known;
    input.markers = marker_metrics();
    evaluation::ExpectedAccuracy expected;
    for (auto* value : {&expected.end_bound_m,
                        &expected.end_expected_m,
                        &expected.ate_bound_m,
                        &expected.ate_expected_m,
                        &expected.loop_residual_m,
                        &expected.imu_vision_disagreement_deg,
                        &expected.reprojection_rms_px})
        *value = 0.01;
    expected.covariance_scale = 1.0;
    for (const char* name : {"markers", "accelerometer", "pressure", "known_distances"})
        expected.scales.push_back({name, {1.01, 0.02}});
    input.scale_correction = evaluation::combined_scale({expected.scales[0]}, 0.003);
    expected.surface = evaluation::ExpectedSurface{0.1, 0.2, 0.7, 0.003, 0.02, 0.01};
    expected.left_out = {{"trajectory.loops", "none"}};
    input.expected = expected;
    input.evaluation.findings = {{Severity::Info, "x", "", "seen", ""}};
    return input;
}

TEST(MetricsDocument, FitsItsSchemaWithAndWithoutTruthAndSurface) {
    EXPECT_TRUE(is_valid(metrics_document(plain_dive())));
    EXPECT_TRUE(is_valid(metrics_document(dive_with_everything())));
}

TEST(MetricsDocument, FitsItsSchemaWithACalibrationInAnotherMedium) {
    MetricsInput input = plain_dive();
    for (types::Rig* rig : {&input.rig, &input.used_rig})
        for (types::Camera* camera : {&rig->cam0, &rig->cam1}) camera->refractive_index = 1.337;
    input.alignment.outcome = types::RigAlignment::Outcome::Moved;
    input.alignment.num_inliers = 100;
    input.alignment.change.medium.refractive_index = 1.337;

    const json document = metrics_document(input);

    EXPECT_TRUE(is_valid(document));
    EXPECT_EQ(document["calibration"]["alignment"]["medium"]["refractive_index"], 1.337);
}

TEST(MetricsDocument, FitsItsSchemaWithARightCameraThatMovedInMidDive) {
    MetricsInput input = plain_dive();
    input.alignment.outcome = types::RigAlignment::Outcome::AsStated;
    input.alignment.num_inliers = 100;
    types::RigPart part{.first_frame = 60, .num_frames = 90, .from_ns = 6'500'000'000};
    part.found = true;
    part.values[types::RigChange::kPitch] = std::numbers::pi / 360.0;
    part.sigmas[types::RigChange::kPitch] = 1e-4;
    part.shift_px = 2.5;
    types::RigPart by_yaw_alone{.first_frame = 150, .num_frames = 9, .from_ns = 15'500'000'000};
    by_yaw_alone.found = true;
    by_yaw_alone.values[types::RigChange::kYaw] = 0.01;
    by_yaw_alone.sigmas[types::RigChange::kYaw] = 1e-4;
    input.alignment.parts = {
        {.num_frames = 60, .from_ns = 500'000'000, .found = true}, part, by_yaw_alone};

    const json document = metrics_document(input);

    EXPECT_TRUE(is_valid(document));
    const json& parts = document["calibration"]["alignment"]["parts"];
    ASSERT_EQ(parts.size(), 3U);
    EXPECT_FALSE(parts[0].contains("change"));
    EXPECT_TRUE(parts[2]["change"].contains("yaw_deg"));
    EXPECT_EQ(parts[1]["from_s"], 6.0);
    EXPECT_NEAR(parts[1]["change"]["pitch_deg"]["value"].get<double>(), 0.5, 1e-12);
    EXPECT_FALSE(parts[1]["change"].contains("yaw_deg"));
}

TEST(MetricsDocument, FitsItsSchemaWithCamerasBehindPorts) {
    MetricsInput input = plain_dive();
    input.used_rig.cam0.port = types::Port{.distance_m = 0.025, .water_index = 1.34};
    input.used_rig.cam1.port =
        types::Port{.shape = types::Port::Shape::Dome, .radius_m = 0.05, .water_index = 1.34};

    const json document = metrics_document(input);

    EXPECT_TRUE(is_valid(document));
    const json& rig = document["calibration"]["rig"];
    EXPECT_EQ(rig["cam0"]["port"]["distance_m"], 0.025);
    EXPECT_EQ(rig["cam1"]["port"]["type"], "dome");
}

TEST(MetricsDocument, FitsItsSchemaWithEveryLightAndWithWaterThatIsNotKnown) {
    MetricsInput input = plain_dive();
    EXPECT_FALSE(metrics_document(input).contains("color"));
    for (const auto light : kLightSources) {
        const WaterColor water = known_water(light);
        input.color = &water;
        const json document = metrics_document(input);
        EXPECT_TRUE(is_valid(document)) << document["color"];
        EXPECT_EQ(document["color"]["light"], color::to_string(light));
    }
    for (const auto outcome : kFailedOutcomes)
        for (WaterColor water : {known_water(), WaterColor()}) {
            water.fit.outcome = outcome;
            input.color = &water;
            const json document = metrics_document(input);
            EXPECT_TRUE(is_valid(document)) << document["color"];
            EXPECT_EQ(document["color"]["outcome"], color::to_string(outcome));
            EXPECT_EQ(document["color"]["restored"], false);
        }
}

TEST(MetricsDocument, TheSchemaRefusesWaterThatNoDiveHas) {
    const auto is_valid_with = [](const char* pointer, const json& value) {
        json document = metrics_document(dive_with_everything());
        document.at(json::json_pointer(pointer)) = value;
        return is_valid(document);
    };
    EXPECT_TRUE(is_valid_with("/color/near_m", 0.5));
    EXPECT_FALSE(is_valid_with("/color/near_m", -0.5));
    EXPECT_FALSE(is_valid_with("/color/outcome", "unknown"));
    EXPECT_FALSE(is_valid_with("/color/light", "moon"));
    EXPECT_FALSE(is_valid_with("/color/explained_share", 1.5));
    EXPECT_FALSE(is_valid_with("/color/white_point", {1.9, 2.1}));
    for (const char* channel : {"/color/red/veil", "/color/green/veil", "/color/blue/veil"})
        EXPECT_FALSE(is_valid_with(channel, 0.1)) << channel << " without its sigma";
}

TEST(MetricsDocument, AnEstimatedImuIsToldWithoutLenses) {
    MetricsInput input = plain_dive();
    EXPECT_FALSE(metrics_document(input)["calibration"].contains("refined"));
    input.rig.imu_noise = types::ImuNoise{};
    input.refined.imu.time_offset_s = 0.012;
    input.refined.time_offset_sigma_s = 1e-4;
    input.refined.time_offset_applied = true;

    const json document = metrics_document(input);

    EXPECT_TRUE(is_valid(document));
    const json& refined = document["calibration"]["refined"];
    EXPECT_EQ(refined["time_offset_s"]["value"], 0.012);
    EXPECT_EQ(refined["time_offset_s"]["applied"], true);
    EXPECT_TRUE(refined.contains("rotation_deg"));
    EXPECT_FALSE(refined.contains("lenses"));
}

TEST(MetricsDocument, TheSchemaRefusesWhatIsMissingUnknownOrOfTheWrongType) {
    const json good = metrics_document(dive_with_everything());
    json bad = good;
    bad.erase("frames");
    EXPECT_FALSE(is_valid(bad));
    bad = good;
    bad["mesh"]["surprise"] = 1;
    EXPECT_FALSE(is_valid(bad));
    bad = good;
    bad["trajectory"]["final"]["ate_rmse_m"] = "small";
    EXPECT_FALSE(is_valid(bad));
    bad = good;
    bad["frames"]["coverage"] = 1.5;
    EXPECT_FALSE(is_valid(bad));
}

TEST(MetricsDocument, TheSchemaDescribesEveryFieldOfTheDocument) {
    const json schema =
        json::parse(std::ifstream(source_directory() / "schemas" / "metrics.schema.json"));
    const json document = metrics_document(dive_with_everything());
    int num_fields = 0;
    for (const auto& [section, fields] : document.items()) {
        if (!fields.is_object() || section == "options") continue;
        for (const auto& [name, value] : fields.items()) {
            const json& field = schema["properties"][section]["properties"][name];
            EXPECT_TRUE(field.contains("description") || field.contains("$ref"))
                << section << "." << name;
            ++num_fields;
        }
    }
    EXPECT_GT(num_fields, 40);
}

// Appends what a schema says of each field of this name.
void collect_fields(const json& schema, const std::string& name, std::vector<json>& found) {
    if (schema.is_object() && schema.contains("properties") && schema["properties"].contains(name))
        found.push_back(schema["properties"][name]);
    if (schema.is_structured())
        for (const json& part : schema) collect_fields(part, name, found);
}

TEST(MetricsDocument, TheSchemaKnowsEveryLensModelWhereverACameraIsDescribed) {
    json names = json::array();
    for (const camera::LensModel& model : camera::lens_models()) names.push_back(model.name);
    std::vector<json> found;
    collect_fields(
        json::parse(std::ifstream(source_directory() / "schemas" / "metrics.schema.json")),
        "distortion_model",
        found);
    EXPECT_EQ(found.size(), 3U);
    for (const json& field : found) EXPECT_EQ(field["enum"], names);
}

TEST(MetricsDocument, SpeedLeavesOutEvaluationAndReusedStages) {
    MetricsInput input = plain_dive();
    EXPECT_EQ(metrics_document(input)["speed"]["frames_per_s"], 20.0);
    EXPECT_EQ(metrics_document(input)["speed"]["stages"][0]["frames_per_s"], 25.0);
    input.stages[0].reused = true;
    EXPECT_FALSE(metrics_document(input)["speed"].contains("frames_per_s"));
    EXPECT_FALSE(metrics_document(input)["speed"]["stages"][0].contains("frames_per_s"));
}

TEST(MetricsDocument, TheCalibrationHashChangesWithTheCalibrationAlone) {
    const auto hash = [](const MetricsInput& input) {
        return metrics_document(input)["calibration"]["sha256"];
    };
    MetricsInput other = plain_dive();
    other.preset = "standard";
    EXPECT_EQ(hash(other), hash(plain_dive()));
    other.stated_rig.cam1.distortion_coefficients[2] = 1e-5;
    EXPECT_NE(hash(other), hash(plain_dive()));
    MetricsInput behind_glass = plain_dive();
    behind_glass.stated_rig.cam0.port = types::Port{.distance_m = 0.025};
    EXPECT_NE(hash(behind_glass), hash(plain_dive()));
}

TEST(MetricsDocument, CoverageIsTheShareOfFramesConstrainedByVision) {
    EXPECT_DOUBLE_EQ(metrics_document(plain_dive())["frames"]["coverage"], 0.9);
}

TEST(MetricsDocument, ASceneThatIsTooNearTellsHowFarItsImagesWereSearched) {
    MetricsInput input = plain_dive();
    input.track.dense = {100, 12'800, 4000, 0, 400};
    const auto says = [&](const std::string& words) {
        return metrics_document(input)["findings"].back().dump().find(words) != std::string::npos;
    };
    EXPECT_TRUE(says("scene_too_near"));
    EXPECT_TRUE(says("range (128 px)"));
    EXPECT_TRUE(says("larger num_disparities_px"));
    input.rig.cam0.width_px = 1920;
    EXPECT_TRUE(says("range (512 px)"));
    EXPECT_FALSE(says("larger num_disparities_px")) << "it is as large as it can be";
    input.reduction = 3;
    EXPECT_TRUE(says("range (128 px)"));
}

TEST(MetricsDocument, TellsWhetherASensorKnowsTheVertical) {
    MetricsInput input = plain_dive();
    EXPECT_EQ(metrics_document(input)["trajectory"]["vertical_known"], true);
    input.vertical_is_known = false;
    EXPECT_EQ(metrics_document(input)["trajectory"]["vertical_known"], false);
    EXPECT_TRUE(is_valid(metrics_document(input)));
}

TEST(MetricsDocument, CoverageOfTheSurfaceIsOverWhatWasMatched) {
    MetricsInput input = dive_with_everything();
    input.mesh->coverage = {{1, 0.9, 0.5, 0.4}, {2, 0.7, 0.3, 0.2}};
    const json mesh = metrics_document(input)["mesh"];
    EXPECT_NEAR(mesh["covered_share"].get<double>(), 0.8, 1e-12);
    EXPECT_NEAR(mesh["covered_share_of_matched"].get<double>(), 0.6 / 0.8, 1e-12);
    EXPECT_EQ(mesh["covered_images"].size(), 2U);
}

TEST(MetricsDocument, PeakMemoryCountsWhatWasGivenBack) {
    const std::int64_t before = peak_memory_bytes();
    EXPECT_GT(before, 1'000'000);
    { const std::vector<char> block(300'000'000, 'x'); }
    EXPECT_GT(peak_memory_bytes(), 290'000'000);
}

}  // namespace
}  // namespace divemesh::pipeline
