#include "worker/pipeline/reconstruct_dive.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <memory>
#include <nlohmann/json.hpp>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <set>
#include <stdexcept>
#include <utility>
#include <vector>

#include "schemas/error.hpp"
#include "schemas/finding.hpp"
#include "schemas/json.hpp"
#include "schemas/verdict.hpp"
#include "storage/blob_store.hpp"
#include "tests/temporary_folder.hpp"
#include "tests/worker/pipeline/blob_stage_store.hpp"
#include "worker/dive/dive.hpp"
#include "worker/io/ply.hpp"
#include "worker/pipeline/link_or_copy.hpp"
#include "worker/pipeline/reconstruction_stages.hpp"
#include "worker/pipeline/stage_cache.hpp"
#include "worker/pipeline/stage_files.hpp"
#include "worker/simulator/dive_files.hpp"
#include "worker/simulator/simulate.hpp"

namespace divemesh::pipeline {
namespace {

namespace fs = std::filesystem;

std::string content(const fs::path& file) {
    std::ifstream stream(file, std::ios::binary);
    return {std::istreambuf_iterator<char>(stream), {}};
}

std::set<std::string> names_in(const fs::path& folder) {
    std::set<std::string> names;
    for (const auto& entry : fs::directory_iterator(folder)) names.insert(entry.path().filename());
    return names;
}

class ReconstructDiveTest : public testing::Test {
protected:
    static void SetUpTestSuite() {
        rendered_ = std::make_unique<TemporaryFolder>();
        simulator::simulate({.scene = simulator::SceneKind::Tank,
                             .out = rendered_->path() / "dive",
                             .length_m = 0.2,
                             .rate_hz = 8.0,
                             .width_px = 160,
                             .height_px = 120});
        // A million samples take too long here.
        fs::remove(rendered_->path() / "dive/reference.ply");
    }
    static void TearDownTestSuite() { rendered_.reset(); }

    ReconstructDiveTest() {
        fs::copy(rendered_->path() / "dive", folder_ / "dive", fs::copy_options::recursive);
    }
    ReconstructionRequest request(const std::string& name, const nlohmann::json& overrides) const {
        return {.dive = folder_ / "dive",
                .out = folder_ / name,
                .scratch = folder_ / (name + "-scratch"),
                .cache = cache_,
                .cache_bytes = std::int64_t{1} << 30,
                .options = make_options("standard", overrides)};
    }
    // Expects that a run never decreases the progress and brings it to 1.
    template <typename Run>
    nlohmann::json with_progress(const Run& run) {
        double last_fraction = 0.0;
        auto metrics = run([&](const Progress& progress) {
            EXPECT_GE(progress.fraction, last_fraction);
            last_fraction = progress.fraction;
        });
        EXPECT_NEAR(last_fraction, 1.0, 1e-9);
        return metrics;
    }
    nlohmann::json reconstruct(const std::string& name, const nlohmann::json& overrides) {
        return with_progress([&](const base::ProgressCallback& progress) {
            return reconstruct_dive(request(name, overrides), progress);
        });
    }

    std::set<std::string> reused(const nlohmann::json& metrics) {
        std::set<std::string> names;
        for (const auto& stage : metrics["speed"]["stages"])
            if (stage["reused"]) names.insert(stage["stage"]);
        return names;
    }
    void expect_same_files(const std::string& one, const std::string& other) {
        int num_compared = 0;
        for (const auto& entry : fs::recursive_directory_iterator(folder_ / one)) {
            const auto name = entry.path().lexically_relative(folder_ / one);
            if (!entry.is_regular_file() || name == "metrics.json" || name == "report.html")
                continue;  // these state how long the run took
            EXPECT_EQ(content(entry.path()), content(folder_ / other / name)) << name;
            ++num_compared;
        }
        EXPECT_GT(num_compared, 3);
    }

    static inline std::unique_ptr<TemporaryFolder> rendered_;
    TemporaryFolder folder_;
    fs::path cache_;  // empty: no cache
};

TEST_F(ReconstructDiveTest, WithoutASurfaceTheTrajectoriesAreTheSameAndNothingElseIsMade) {
    const auto whole = reconstruct("whole", {{"voxel_m", 0.02}});
    const auto alone = reconstruct("alone", {{"surface", false}});
    EXPECT_EQ(names_in(folder_ / "alone"),
              (std::set<std::string>{"trajectory.tum",
                                     "trajectory_causal.tum",
                                     "trajectory_covariance.csv",
                                     "metrics.json",
                                     "certificate.json",
                                     "report.html"}));
    for (const auto* name :
         {"trajectory.tum", "trajectory_causal.tum", "trajectory_covariance.csv"})
        EXPECT_EQ(content(folder_ / "alone" / name), content(folder_ / "whole" / name)) << name;
    EXPECT_EQ(alone["trajectory"], whole["trajectory"]);
    EXPECT_TRUE(whole.contains("mesh"));
    EXPECT_FALSE(alone.contains("mesh"));
}

// Makes all images from the second frame on grey, as in blue water.
void blank_all_but_the_first(const fs::path& dive) {
    for (const char* camera : {"cam0", "cam1"}) {
        std::set<fs::path> images;
        for (const auto& entry : fs::directory_iterator(dive / "mav0" / camera / "data"))
            images.insert(entry.path());
        images.erase(images.begin());
        for (const fs::path& image : images)
            cv::imwrite(image.string(), cv::Mat(120, 160, CV_8UC1, cv::Scalar(80)));
    }
}

TEST_F(ReconstructDiveTest, ADiveThatCannotBeTrackedKeepsWhatIsKnownAndIsNotUsable) {
    blank_all_but_the_first(folder_ / "dive");
    const auto metrics = reconstruct("blank", {{"voxel_m", 0.02}});
    EXPECT_EQ(metrics["verdict"], "not_usable");
    EXPECT_EQ(metrics["restrictions"], nlohmann::json({"all"}));
    EXPECT_EQ(metrics["frames"]["num_frames_predicted"], metrics["frames"]["num_frames"]);
    EXPECT_EQ(metrics["trajectory"]["path_length_m"], 0.0);
    EXPECT_EQ(names_in(folder_ / "blank"),
              (std::set<std::string>{"trajectory.tum",
                                     "trajectory_causal.tum",
                                     "trajectory_covariance.csv",
                                     "trajectory_predicted.tum",
                                     "metrics.json",
                                     "certificate.json",
                                     "report.html"}));
    EXPECT_NE(content(folder_ / "blank/report.html").find("Not usable"), std::string::npos);
}

const nlohmann::json* finding_of(const nlohmann::json& metrics, const std::string& code) {
    for (const auto& finding : metrics["findings"])
        if (finding["code"] == code) return &finding;
    return nullptr;
}

TEST_F(ReconstructDiveTest, BlackImagesOfOneCameraAreToldWhereTheyLeaveNoModel) {
    for (const auto& image : fs::directory_iterator(folder_ / "dive/mav0/cam1/data"))
        cv::imwrite(image.path().string(), cv::Mat(120, 160, CV_8UC1, cv::Scalar(0)));
    const auto metrics = reconstruct("black", {{"voxel_m", 0.02}});
    ASSERT_NE(finding_of(metrics, "nothing_reconstructed"), nullptr) << metrics["findings"];
    const auto* black = finding_of(metrics, "images_black");
    ASSERT_NE(black, nullptr) << metrics["findings"];
    EXPECT_EQ((*black)["where"], "mav0/cam1/data");
    // A job fails with the first error: the cause.
    EXPECT_EQ(first_error(metrics["findings"].get<std::vector<Finding>>())->code, "images_black");
}

TEST_F(ReconstructDiveTest, ADiveOfWhichNoImageDecodesSaysSo) {
    for (const auto& image : fs::directory_iterator(folder_ / "dive/mav0/cam0/data"))
        std::ofstream(image.path()) << "GIF89a";
    const auto metrics = reconstruct("unreadable", {{"voxel_m", 0.02}});
    EXPECT_NE(finding_of(metrics, "nothing_reconstructed"), nullptr) << metrics["findings"];
    EXPECT_EQ(first_error(metrics["findings"].get<std::vector<Finding>>())->code,
              "no_frame_decodes");
}

TEST_F(ReconstructDiveTest, ADiveThatIsRefusedTellsItsFindingsFirst) {
    fs::remove(folder_ / "dive/mav0/cam1/sensor.yaml");
    std::vector<Finding> told;
    auto refused = request("refused", nlohmann::json::object());
    refused.dive_checked = [&](const std::vector<Finding>& findings) { told = findings; };
    EXPECT_THROW(reconstruct_dive(refused, base::ignore_progress), Error);
    EXPECT_TRUE(has_error(told));
}

TEST_F(ReconstructDiveTest, ARefusedDiveLeavesNothingOfAnEarlierResultButWhatItsUserKeeps) {
    reconstruct("model",
                {{"voxel_m", 0.02},
                 {"exports", "kitti,euroc,obj,ply,colmap,nerfstudio,las,laz,e57,3dtiles,mcap"}});
    ASSERT_TRUE(fs::exists(folder_ / "model/mosaic.pgw"));
    ASSERT_TRUE(fs::exists(folder_ / "model/heights_sigma.tif"));
    std::ofstream(folder_ / "model/notes.txt") << "kept";
    fs::remove(folder_ / "dive/mav0/cam1/sensor.yaml");
    EXPECT_THROW(
        reconstruct_dive(request("model", nlohmann::json::object()), base::ignore_progress), Error);
    EXPECT_EQ(names_in(folder_ / "model"), (std::set<std::string>{"notes.txt"}));
}

TEST_F(ReconstructDiveTest, WhatIsNoDiveOrAWrongOptionRemovesNothing) {
    fs::create_directories(folder_ / "model");
    for (const char* name : {"model/mesh.ply", "model/metrics.json", "note.txt"})
        std::ofstream(folder_ / name) << "kept";
    for (const char* dive : {"dvie", "note.txt"}) {
        auto mistyped = request("model", nlohmann::json::object());
        mistyped.dive = folder_ / dive;
        EXPECT_THROW(reconstruct_dive(mistyped, base::ignore_progress), Error) << dive;
    }
    EXPECT_THROW(
        reconstruct_dive(request("model", {{"correct_scale", "on"}}), base::ignore_progress),
        Error);
    EXPECT_TRUE(fs::exists(folder_ / "model/mesh.ply"));
}

// The images say nothing against the rig: all but the first pair are blank.
TEST_F(ReconstructDiveTest, ADiveWhoseCamerasShareNoFieldOfViewIsRefused) {
    blank_all_but_the_first(folder_ / "dive");
    types::Rig rig = dive::Dive::open(folder_ / "dive", folder_ / "opened")->rig();
    for (types::Camera* camera : {&rig.cam0, &rig.cam1}) {
        camera->fx_px *= 4.0;
        camera->fy_px *= 4.0;
    }
    rig.T_imu_cam1.rotate(Eigen::AngleAxisd(-0.6, Eigen::Vector3d::UnitY()));  // inward
    simulator::write_camera_yaml(folder_ / "dive/mav0/cam0", rig.cam0, rig.T_imu_cam0, 8.0);
    simulator::write_camera_yaml(folder_ / "dive/mav0/cam1", rig.cam1, rig.T_imu_cam1, 8.0);
    std::vector<Finding> told;
    auto refused = request("refused", nlohmann::json::object());
    refused.dive_checked = [&](const std::vector<Finding>& findings) { told = findings; };
    EXPECT_THROW(reconstruct_dive(refused, base::ignore_progress), Error);
    ASSERT_FALSE(told.empty());
    EXPECT_EQ(told.back().code, "calibration_no_overlap");
}

// Returns the names of the stages that leave files where colours stay as recorded, up to and
// without `end`; "": all of them.
std::set<std::string> kept_stages_before(const std::string& end) {
    std::set<std::string> names;
    for (const StageSpec& spec : specs_of(reconstruction_stages())) {
        if (spec.name == end) break;
        if (!spec.files.empty() && spec.name != "color") names.insert(spec.name);
    }
    return names;
}

// Options that differ decide which stages are reused and which run again; the bytes are those of a
// run without a cache.
TEST_F(ReconstructDiveTest, ARunStartsWhereItDiffersFromAnEarlierOne) {
    const nlohmann::json plain = {{"voxel_m", 0.02}};
    const nlohmann::json coarse = {{"voxel_m", 0.03}};
    const nlohmann::json meshed = {{"voxel_m", 0.03}, {"max_sigma_m", 0.02}, {"simplify", 0.5}};
    const nlohmann::json stated = {{"voxel_m", 0.03}, {"refine_lenses", false}};
    reconstruct("fresh-coarse", coarse);
    reconstruct("fresh-meshed", meshed);
    reconstruct("fresh-stated", stated);
    cache_ = folder_ / "cache";
    EXPECT_TRUE(reused(reconstruct("first", plain)).empty());

    ASSERT_GE(kept_stages_before("").size(), 6U);
    EXPECT_EQ(reused(reconstruct("again", plain)), kept_stages_before(""));
    EXPECT_EQ(reused(reconstruct("coarse", coarse)), kept_stages_before("fuse"));
    EXPECT_EQ(reused(reconstruct("meshed", meshed)), kept_stages_before("mesh"));
    EXPECT_EQ(reused(reconstruct("stated", stated)), kept_stages_before("optimise"));

    expect_same_files("first", "again");
    expect_same_files("fresh-coarse", "coarse");
    expect_same_files("fresh-meshed", "meshed");
    expect_same_files("fresh-stated", "stated");
}

// What reading the images found is told by a run that does not read them again.
TEST_F(ReconstructDiveTest, ABrokenImageIsToldByEveryRun) {
    const fs::path broken = *fs::directory_iterator(folder_ / "dive/mav0/cam1/data");
    fs::resize_file(broken, 100);
    cache_ = folder_ / "cache";
    const auto first = reconstruct("first", {{"voxel_m", 0.03}});
    const auto again = reconstruct("again", {{"voxel_m", 0.03}, {"cloud_spacing_m", 0.05}});
    ASSERT_EQ(reused(again), kept_stages_before("fuse"));
    const auto num_undecodable = [](const nlohmann::json& metrics) {
        return std::ranges::count_if(metrics["findings"], [](const nlohmann::json& finding) {
            return finding["code"] == "image_undecodable";
        });
    };
    EXPECT_EQ(num_undecodable(first), 1);
    EXPECT_EQ(num_undecodable(again), 1);
    EXPECT_EQ(first["findings"], again["findings"]);
    EXPECT_EQ(first["verdict"], again["verdict"]);
}

TEST_F(ReconstructDiveTest, AnAttemptGoesOnFromWhatTheOneBeforeLeftInItsScratchFolder) {
    const nlohmann::json options = {{"voxel_m", 0.02}};
    reconstruct("first", options);
    fs::rename(folder_ / "first-scratch", folder_ / "again-scratch");
    fs::remove(folder_ / "again-scratch/mesh.stage");

    auto all_but_mesh = kept_stages_before("");
    all_but_mesh.erase("mesh");
    EXPECT_EQ(reused(reconstruct("again", options)), all_but_mesh);

    expect_same_files("first", "again");
}

// The tank holds no water.
TEST_F(ReconstructDiveTest, ADiveInAirKeepsItsColoursAndSaysSo) {
    cache_ = folder_ / "cache";
    const auto raw = reconstruct("raw", {{"voxel_m", 0.02}});
    const auto asked = reconstruct("asked", {{"voxel_m", 0.02}, {"color", "restored"}});

    EXPECT_EQ(reused(asked), kept_stages_before("color"));
    EXPECT_FALSE(raw.contains("color"));
    EXPECT_EQ(finding_of(raw, "color_not_restored"), nullptr);
    ASSERT_TRUE(asked.contains("color"));
    EXPECT_EQ(asked["color"]["restored"], false) << asked["color"];
    EXPECT_NE(finding_of(asked, "color_not_restored"), nullptr) << asked["findings"];
    EXPECT_EQ(asked["restrictions"], raw["restrictions"]);
    for (const char* name : {"mesh.ply", "mesh.glb", "mosaic.png"})
        EXPECT_EQ(content(folder_ / "asked" / name), content(folder_ / "raw" / name)) << name;
}

// The level that is left of a pixel whose light is halved.
const double kHalfLight = std::pow(0.5, 1.0 / 2.2);

std::vector<types::Color> with_half_the_light(std::vector<types::Color> colors) {
    for (types::Color& color : colors)
        for (std::uint8_t& level : color)
            level = static_cast<std::uint8_t>(std::lround(kHalfLight * level));
    return colors;
}

// Water that takes no light, and a white with twice the light of white in the images.
void run_half_the_light(Reconstruction& made, const base::ProgressCallback&) {
    WaterColor water;
    water.fit.outcome = color::FitOutcome::Estimated;
    water.fit.near_m = 0.5;
    water.fit.far_m = 4.0;
    water.fit.log_gains.assign(made.optimised.keyframes.size(), 0.0);
    water.white.white.fill(2.0);
    water.vertices = with_half_the_light(made.surface.mesh.colors);
    made.color = std::move(water);
}

Stage<Reconstruction>& color_stage_of(std::vector<Stage<Reconstruction>>& stages) {
    return *std::ranges::find_if(stages,
                                 [](const auto& stage) { return stage.spec.name == "color"; });
}

// Returns the mean level of the pixels of a mosaic that show surface.
double mean_level(const fs::path& mosaic) {
    const cv::Mat image = cv::imread(mosaic.string(), cv::IMREAD_UNCHANGED);
    if (image.type() != CV_8UC4) throw std::runtime_error("not a mosaic: " + mosaic.string());
    cv::Mat is_surface;
    cv::extractChannel(image, is_surface, 3);
    const cv::Scalar mean = cv::mean(image, is_surface);
    return (mean[0] + mean[1] + mean[2]) / 3.0;
}

// Expects that a reconstruction shows the surface of `raw` with half the light.
void expect_half_the_light(const fs::path& restored, const fs::path& raw) {
    const types::Mesh before = io::read_ply(raw / "mesh.ply");
    const types::Mesh after = io::read_ply(restored / "mesh.ply");
    ASSERT_FALSE(before.colors.empty());
    EXPECT_EQ(after.vertices, before.vertices);
    EXPECT_EQ(after.triangles, before.triangles);
    EXPECT_EQ(after.sigma_m, before.sigma_m);
    EXPECT_EQ(after.colors, with_half_the_light(before.colors));
    EXPECT_NEAR(
        mean_level(restored / "mosaic.png") / mean_level(raw / "mosaic.png"), kHalfLight, 0.03);
    EXPECT_NE(content(restored / "mesh.glb"), content(raw / "mesh.glb"));
}

// Expects that what is never restored is the same in two reconstructions.
void expect_same_recorded_colors(const fs::path& one, const fs::path& other) {
    EXPECT_EQ(content(one / "cloud.ply"), content(other / "cloud.ply"));
    const std::set<std::string> images = names_in(one / "keyframes");
    ASSERT_FALSE(images.empty());
    for (const std::string& image : images)
        EXPECT_EQ(content(one / "keyframes" / image), content(other / "keyframes" / image))
            << image;
}

TEST_F(ReconstructDiveTest, RestoredColoursAreOnTheSameSurfaceAndInItsPhotographs) {
    auto stages = reconstruction_stages();
    color_stage_of(stages).run = run_half_the_light;
    cache_ = folder_ / "cache";
    StageCache store(cache_, std::int64_t{1} << 30);
    const auto restored = [&](const std::string& name) {
        const auto of = request(name, {{"voxel_m", 0.02}, {"color", "restored"}});
        return with_progress([&](const base::ProgressCallback& progress) {
            return reconstruct_dive(of, stages, store, progress);
        });
    };
    reconstruct("raw", {{"voxel_m", 0.02}});
    const auto metrics = restored("restored");
    EXPECT_EQ(reused(metrics), kept_stages_before("color"));
    EXPECT_EQ(metrics["color"]["restored"], true);
    EXPECT_EQ(finding_of(metrics, "color_not_restored"), nullptr);
    expect_half_the_light(folder_ / "restored", folder_ / "raw");
    expect_same_recorded_colors(folder_ / "restored", folder_ / "raw");

    auto all_and_color = kept_stages_before("");
    all_and_color.insert("color");
    EXPECT_EQ(reused(restored("again")), all_and_color);
    expect_same_files("restored", "again");
}

TEST_F(ReconstructDiveTest, ColoursAreRestoredIfThatIsAskedAndThereIsAPath) {
    auto stages = reconstruction_stages();
    const auto wanted = [&](const nlohmann::json& overrides, const std::vector<Finding>& findings) {
        const auto of = request("model", overrides);
        Reconstruction made(of);
        made.optimised.findings = findings;
        return color_stage_of(stages).wanted(made);
    };
    EXPECT_TRUE(wanted({{"color", "restored"}}, {}));
    EXPECT_FALSE(wanted({{"color", "raw"}}, {}));
    EXPECT_FALSE(wanted({{"color", "restored"}}, {{Severity::Error, "nothing_reconstructed"}}));
}

// An extra stage between mesh and texture: it writes the number of triangles to a file of its own.
bool load_count(Reconstruction& made, const std::string& key) {
    return load_texture_metrics(made.scratch("count.stage"), key).has_value();
}
void run_count(Reconstruction& made, const base::ProgressCallback&) {
    std::ofstream(made.scratch("count.txt")) << made.surface.mesh.triangles.size();
}
void save_count(Reconstruction& made, const std::string& key) {
    save_texture_metrics(made.scratch("count.stage"), key, {});
}
void finish_count(Reconstruction& made) {
    link_or_copy(made.scratch("count.txt"), made.artifact("count.txt"));
}

std::vector<Stage<Reconstruction>> stages_with_count() {
    auto stages = reconstruction_stages();
    const auto texture = std::ranges::find_if(
        stages, [](const auto& stage) { return stage.spec.name == "texture"; });
    stages.insert(texture,
                  {.spec = {.name = "count", .share = 0.1, .files = {"count.txt", "count.stage"}},
                   .load = load_count,
                   .run = run_count,
                   .save = save_count,
                   .finish = finish_count});
    return stages;
}

// The results of all stages, also of the added one, are stored as blobs and fetched again.
TEST_F(ReconstructDiveTest, AStageMoreAndAStoreOfBlobsMakeTheSameFiles) {
    const nlohmann::json options = {{"voxel_m", 0.02}};
    const auto plain = reconstruct("plain", options);
    const auto blobs = storage::open_blob_store(folder_ / "blobs");
    BlobStageStore store(*blobs);
    const auto counted = [&](const std::string& name) {
        return with_progress([&](const base::ProgressCallback& progress) {
            return reconstruct_dive(request(name, options), stages_with_count(), store, progress);
        });
    };

    EXPECT_TRUE(reused(counted("first")).empty());
    auto all_and_count = kept_stages_before("");
    all_and_count.insert("count");
    EXPECT_EQ(reused(counted("again")), all_and_count);

    for (const char* name : {"first", "again"}) {
        expect_same_files("plain", name);
        EXPECT_EQ(content(folder_ / name / "count.txt"), plain["mesh"]["num_triangles"].dump());
    }
}

}  // namespace
}  // namespace divemesh::pipeline
