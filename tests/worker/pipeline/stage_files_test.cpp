#include "worker/pipeline/stage_files.hpp"

#include <gtest/gtest.h>

#include <filesystem>

#include "tests/temporary_folder.hpp"
#include "tests/worker/pipeline/known_water.hpp"

namespace divemesh::pipeline {
namespace {

types::Track small_track() {
    types::Track track;
    track.rig.focal_px = 480.0;
    track.rig.T_imu_cam.translation() = Eigen::Vector3d(0.1, 0.2, 0.3);
    for (int i = 0; i < 3; ++i) {
        types::StampedPose pose{.timestamp_ns = 1000 + i};
        pose.T_world_imu.translate(Eigen::Vector3d(i, 0.0, 0.0));
        track.causal.push_back(pose);
    }
    track.sigmas = {{}, {0.01, 0.002}};
    track.motions = {types::MotionSource::Nothing, types::MotionSource::Imu};
    track.breaks_ns = {1002};
    track.features = {{300, 290}, {5, 0}};
    track.keyframes.push_back({.frame_index = 2, .timestamp_ns = 1002});
    track.mapped = {{.frame_index = 1, .timestamp_ns = 1001}, track.keyframes[0]};
    types::Landmark landmark;
    landmark.p_world = Eigen::Vector3d(1.0, 2.0, 3.0);
    landmark.observations = {{.keyframe = 0, .u_px = 10.5F, .v_px = 20.5F, .disparity_px = 33.0F}};
    track.landmarks.push_back(landmark);
    track.statistics.num_frames = 3;
    return track;
}

TEST(StageFiles, ATrackSurvivesTheDisk) {
    const TemporaryFolder folder;
    const types::Track written = small_track();
    save_track(folder / "track.stage", "key", written);
    const auto read = load_track(folder / "track.stage", "key");

    ASSERT_TRUE(read);
    EXPECT_EQ(read->rig.focal_px, written.rig.focal_px);
    EXPECT_EQ(read->rig.T_imu_cam.matrix(), written.rig.T_imu_cam.matrix());
    ASSERT_EQ(read->causal.size(), 3U);
    EXPECT_EQ(read->causal[2].T_world_imu.matrix(), written.causal[2].T_world_imu.matrix());
    ASSERT_EQ(read->sigmas.size(), 2U);
    EXPECT_EQ(read->sigmas[1].rotation_rad, 0.002);
    EXPECT_EQ(read->motions, written.motions);
    EXPECT_EQ(read->breaks_ns, written.breaks_ns);
    ASSERT_EQ(read->features.size(), 2U);
    EXPECT_EQ(read->features[0].num_with_depth, 290);
    ASSERT_EQ(read->mapped.size(), 2U);
    EXPECT_EQ(read->mapped[0].frame_index, 1);
    ASSERT_EQ(read->landmarks.size(), 1U);
    EXPECT_EQ(read->landmarks[0].p_world, written.landmarks[0].p_world);
    EXPECT_EQ(read->landmarks[0].observations[0].disparity_px, 33.0F);
    EXPECT_EQ(read->statistics.num_frames, 3);
}

TEST(StageFiles, AnotherKeyOrAMissingFileMeansTheStageRunsAgain) {
    const TemporaryFolder folder;
    save_track(folder / "track.stage", "key", small_track());
    EXPECT_FALSE(load_track(folder / "track.stage", "other key"));
    EXPECT_FALSE(load_track(folder / "missing.stage", "key"));
}

// Expects that a file is loaded, but not once it is cut at any byte.
template <typename Load>
void expect_loaded_only_whole(const std::filesystem::path& file, const Load& load) {
    ASSERT_TRUE(load(file, "key"));
    for (auto size = std::filesystem::file_size(file); size-- > 0;) {
        std::filesystem::resize_file(file, size);
        EXPECT_FALSE(load(file, "key")) << "cut at " << size;
    }
}

TEST(StageFiles, AFileCutAtAnyByteIsNotLoaded) {
    const TemporaryFolder folder;
    save_track(folder / "track.stage", "key", small_track());
    expect_loaded_only_whole(folder / "track.stage", load_track);
    save_water_color(folder / "color.stage", "key", known_water());
    expect_loaded_only_whole(folder / "color.stage", load_water_color);
}

TEST(StageFiles, AnOptimisedTrackSurvivesTheDiskWithItsFindings) {
    const TemporaryFolder folder;
    types::OptimisedTrack written;
    written.keyframes.push_back({.frame_index = 2, .timestamp_ns = 1002, .segment = 1});
    written.max_depth_m = 4.5;
    written.findings = {{Severity::Warning, "loops_not_taken", "frame 3", "message", "remedy"}};
    written.statistics.bundle_adjustment = {.num_solves = 2, .num_failed = 1, .final_cost = 7.5};
    written.statistics.check.after.reprojection_rms_px = 0.3;
    written.prior = {.timestamps_ns = {1002},
                     .apart_m = {12.5},
                     .drift = Eigen::MatrixXd::Constant(6, 6, 0.5),
                     .shared = Eigen::MatrixXd::Constant(6, 2, 0.25)};
    save_optimised_track(folder / "optimise.stage", "key", written);
    const auto read = load_optimised_track(folder / "optimise.stage", "key");

    ASSERT_TRUE(read);
    ASSERT_EQ(read->keyframes.size(), 1U);
    EXPECT_EQ(read->keyframes[0].segment, 1);
    EXPECT_EQ(read->max_depth_m, 4.5);
    ASSERT_EQ(read->findings.size(), 1U);
    EXPECT_EQ(read->findings[0].severity, Severity::Warning);
    EXPECT_EQ(read->findings[0].code, "loops_not_taken");
    EXPECT_EQ(read->findings[0].where, "frame 3");
    EXPECT_EQ(read->findings[0].remedy, "remedy");
    EXPECT_EQ(read->statistics.bundle_adjustment.num_failed, 1);
    EXPECT_EQ(read->statistics.bundle_adjustment.final_cost, 7.5);
    EXPECT_EQ(read->statistics.check.after.reprojection_rms_px, 0.3);
    EXPECT_EQ(read->prior.timestamps_ns, written.prior.timestamps_ns);
    EXPECT_EQ(read->prior.apart_m, written.prior.apart_m);
    EXPECT_EQ(read->prior.drift, written.prior.drift);
    EXPECT_EQ(read->prior.shared, written.prior.shared);
}

TEST(StageFiles, AnAlignmentSurvivesTheDisk) {
    const TemporaryFolder folder;
    types::RigAlignment written;
    written.outcome = types::RigAlignment::Outcome::Moved;
    written.applied = true;
    written.num_inliers = 321;
    written.change.values[types::RigChange::kYaw] = 0.01;
    written.change.medium = {1.25, 1.337};
    written.sigmas[types::RigChange::kYaw] = 0.002;
    written.disparity_bias_px = -1.5;
    written.reference_depth_m = 1.3;
    written.row_solver.num_converged = 1;
    written.range_solver.final_cost = 2.5;
    types::RigPart part{.first_frame = 60, .num_frames = 90, .from_ns = 6'000'000'000};
    part.found = true;
    part.values[types::RigChange::kRoll] = 0.02;
    part.sigmas[types::RigChange::kRoll] = 0.001;
    part.shift_px = 2.5;
    written.parts = {{.num_frames = 60}, part};
    save_rig_alignment(folder / "align.stage", "key", written);
    const auto read = load_rig_alignment(folder / "align.stage", "key");

    ASSERT_TRUE(read);
    EXPECT_EQ(read->outcome, written.outcome);
    EXPECT_TRUE(read->applied);
    EXPECT_EQ(read->num_inliers, 321);
    EXPECT_EQ(read->change.values, written.change.values);
    EXPECT_EQ(read->change.medium.focal_scale, 1.25);
    EXPECT_EQ(read->change.medium.refractive_index, 1.337);
    EXPECT_EQ(read->sigmas, written.sigmas);
    EXPECT_EQ(read->disparity_bias_px, -1.5);
    EXPECT_EQ(read->reference_depth_m, 1.3);
    EXPECT_EQ(read->row_solver.num_converged, 1);
    EXPECT_EQ(read->range_solver.final_cost, 2.5);
    ASSERT_EQ(read->parts.size(), 2U);
    EXPECT_EQ(read->parts[0].num_frames, 60);
    EXPECT_FALSE(read->parts[0].found);
    EXPECT_EQ(read->parts[1].first_frame, 60);
    EXPECT_EQ(read->parts[1].num_frames, 90);
    EXPECT_EQ(read->parts[1].from_ns, 6'000'000'000);
    EXPECT_TRUE(read->parts[1].found);
    EXPECT_EQ(read->parts[1].values, part.values);
    EXPECT_EQ(read->parts[1].sigmas, part.sigmas);
    EXPECT_EQ(read->parts[1].shift_px, 2.5);
}

TEST(StageFiles, MetricsOfTheTextureSurviveTheDisk) {
    const TemporaryFolder folder;
    TextureMetrics written;
    written.num_triangles = 7;
    written.simplification = {.num_triangles_before = 70, .rms_m = 0.001, .max_m = 0.004};
    written.num_atlases = 2;
    written.textured_share = 0.75;
    written.texels_per_pixel = 0.5;
    written.lost_frames = {3, 12};
    save_texture_metrics(folder / "texture.stage", "key", written);
    const auto read = load_texture_metrics(folder / "texture.stage", "key");

    ASSERT_TRUE(read);
    EXPECT_EQ(read->num_triangles, 7);
    EXPECT_EQ(read->simplification.max_m, 0.004);
    EXPECT_EQ(read->num_atlases, 2);
    EXPECT_EQ(read->textured_share, 0.75);
    EXPECT_EQ(read->texels_per_pixel, 0.5);
    EXPECT_EQ(read->lost_frames, written.lost_frames);
}

TEST(StageFiles, WaterAndRestoredColoursSurviveTheDisk) {
    const TemporaryFolder folder;
    const WaterColor written = known_water();
    save_water_color(folder / "color.stage", "key", written);
    EXPECT_FALSE(load_water_color(folder / "color.stage", "other key"));
    const auto read = load_water_color(folder / "color.stage", "key");

    ASSERT_TRUE(read);
    EXPECT_EQ(read->fit.outcome, color::FitOutcome::Estimated);
    EXPECT_EQ(read->fit.light, color::LightSource::Mixed);
    EXPECT_TRUE(read->fit.is_fitted);
    EXPECT_EQ(read->fit.channels, written.fit.channels);
    EXPECT_EQ(read->fit.explained_share, written.fit.explained_share);
    EXPECT_EQ(read->fit.vignetting, written.fit.vignetting);
    EXPECT_EQ(read->fit.near_m, written.fit.near_m);
    EXPECT_EQ(read->fit.far_m, written.fit.far_m);
    EXPECT_EQ(read->fit.num_points, written.fit.num_points);
    EXPECT_EQ(read->fit.num_sightings, written.fit.num_sightings);
    EXPECT_EQ(read->fit.log_gains, written.fit.log_gains);
    EXPECT_TRUE(read->fit.surface.empty()) << "only the white point is made of it";
    EXPECT_EQ(read->num_lost_images, written.num_lost_images);
    EXPECT_EQ(read->white.white, written.white.white);
    EXPECT_EQ(read->white.relative, written.white.relative);
    EXPECT_EQ(read->vertices, written.vertices);
    EXPECT_EQ(read->limited_share, written.limited_share);
}

TEST(StageFiles, WaterThatIsNotKnownSurvivesTheDisk) {
    const TemporaryFolder folder;
    WaterColor written;
    written.fit.outcome = color::FitOutcome::NotExplained;
    written.fit.light = color::LightSource::Camera;
    save_water_color(folder / "color.stage", "key", written);
    const auto read = load_water_color(folder / "color.stage", "key");

    ASSERT_TRUE(read);
    EXPECT_EQ(read->fit.outcome, color::FitOutcome::NotExplained);
    EXPECT_EQ(read->fit.light, color::LightSource::Camera);
    EXPECT_FALSE(read->fit.is_fitted);
    EXPECT_TRUE(read->vertices.empty());
}

TEST(StageFiles, AMeshSurvivesTheDisk) {
    const TemporaryFolder folder;
    Surface surface;
    types::Mesh& mesh = surface.mesh;
    mesh.vertices = {{0.0F, 0.0F, 0.0F}, {1.0F, 0.0F, 0.0F}, {0.0F, 1.0F, 0.0F}};
    mesh.sigma_m = {0.001F, 0.002F, 0.003F};
    mesh.sigma_local_m = {0.0005F, 0.001F, 0.002F};
    mesh.triangles = {{0, 1, 2}};
    surface.simplification = mesh::SimplificationError{7, 0.001, 0.002};
    surface.small_components_m2 = 0.25;
    surface.cut_by_sigma_m2 = 1.5;
    save_surface(folder / "mesh.stage", "key", surface);
    const auto read = load_surface(folder / "mesh.stage", "key");

    ASSERT_TRUE(read);
    EXPECT_EQ(read->mesh.vertices, mesh.vertices);
    EXPECT_EQ(read->mesh.sigma_m, mesh.sigma_m);
    EXPECT_EQ(read->mesh.sigma_local_m, mesh.sigma_local_m);
    EXPECT_EQ(read->mesh.triangles, mesh.triangles);
    EXPECT_TRUE(read->mesh.normals.empty());
    ASSERT_TRUE(read->simplification);
    EXPECT_EQ(read->simplification->num_triangles_before, 7);
    EXPECT_EQ(read->simplification->max_m, 0.002);
    EXPECT_EQ(read->small_components_m2, 0.25);
    EXPECT_EQ(read->cut_by_sigma_m2, 1.5);
}

}  // namespace
}  // namespace divemesh::pipeline
