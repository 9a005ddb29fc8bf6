#include "worker/simulator/simulate.hpp"

#include <gtest/gtest.h>

#include <array>
#include <fstream>
#include <iterator>
#include <map>
#include <nlohmann/json.hpp>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <set>
#include <sstream>

#include "schemas/error.hpp"
#include "tests/temporary_folder.hpp"
#include "worker/camera/projection.hpp"
#include "worker/dive/dive.hpp"
#include "worker/io/ply.hpp"
#include "worker/simulator/draw_rig.hpp"
#include "worker/simulator/inertial_sensors.hpp"
#include "worker/simulator/scene.hpp"

namespace divemesh::simulator {
namespace {

namespace fs = std::filesystem;

SimulateOptions small_dive(const fs::path& out) {
    return {.scene = SceneKind::Tank,
            .out = out,
            .length_m = 0.3,
            .rate_hz = 2.0,
            .seed = 5,
            .width_px = 120,
            .height_px = 90};
}

std::string content(const fs::path& file) {
    std::ifstream stream(file, std::ios::binary);
    return {std::istreambuf_iterator<char>(stream), {}};
}

std::map<std::string, std::string> files_of(const fs::path& folder) {
    std::map<std::string, std::string> files;
    for (const auto& entry : fs::recursive_directory_iterator(folder))
        if (entry.is_regular_file())
            files[fs::relative(entry.path(), folder).string()] = content(entry.path());
    return files;
}

std::vector<std::vector<std::string>> rows_of(const fs::path& csv) {
    std::ifstream stream(csv);
    std::vector<std::vector<std::string>> rows;
    for (std::string line; std::getline(stream, line);) {
        if (line.starts_with('#')) continue;
        std::istringstream cells(line);
        auto& row = rows.emplace_back();
        for (std::string cell; std::getline(cells, cell, ',');) row.push_back(cell);
    }
    return rows;
}

TEST(SimulateTest, SameSeedGivesTheSameBytesWithOneThreadAndWithTwo) {
    const TemporaryFolder folder;
    auto options = small_dive(folder / "one");
    options.scene = SceneKind::Barge;
    options.truth = true;
    options.num_threads = 1;
    simulate(options);
    options.out = folder / "two";
    options.num_threads = 2;
    simulate(options);
    const auto one = files_of(folder / "one");
    const auto two = files_of(folder / "two");
    ASSERT_GT(one.size(), 20U);
    ASSERT_EQ(one.size(), two.size());
    for (const auto& [name, bytes] : one) EXPECT_TRUE(two.at(name) == bytes) << name;
}

TEST(SimulateTest, ReferenceSurfaceLandsWhereTheDepthTruthSays) {
    const TemporaryFolder folder;
    auto options = small_dive(folder / "dive");
    options.truth = true;
    simulate(options);
    const types::Mesh reference = io::read_ply(options.out / "reference.ply");
    ASSERT_GT(reference.triangles.size(), 1000U);
    const types::Mesh scene = io::read_ply(options.out / "scene.ply");
    EXPECT_GT(scene.triangles.size(), reference.triangles.size());
    std::set<std::array<float, 3>> positions;
    for (const Eigen::Vector3f& vertex : scene.vertices)
        positions.insert({vertex.x(), vertex.y(), vertex.z()});
    for (const Eigen::Vector3f& vertex : reference.vertices)
        ASSERT_TRUE(positions.contains({vertex.x(), vertex.y(), vertex.z()}));
    const types::Rig rig = draw_rig(options.width_px, options.height_px, options.seed);
    const auto frames = rows_of(options.out / "mav0/cam0/data.csv");
    std::map<std::string, std::vector<std::string>> truth;
    for (const auto& row : rows_of(options.out / "mav0/state_groundtruth_estimate0/data.csv"))
        truth[row[0]] = row;
    for (const int index : {0, 1}) {
        const auto& row = truth.at(frames.back()[0]);
        Eigen::Isometry3d T_world_imu = Eigen::Isometry3d::Identity();
        T_world_imu.translation() =
            Eigen::Vector3d(std::stod(row[1]), std::stod(row[2]), std::stod(row[3]));
        T_world_imu.linear() =
            Eigen::Quaterniond(
                std::stod(row[4]), std::stod(row[5]), std::stod(row[6]), std::stod(row[7]))
                .toRotationMatrix();
        const types::Camera& camera = index == 0 ? rig.cam0 : rig.cam1;
        const Eigen::Isometry3d T_cam_world =
            (T_world_imu * (index == 0 ? rig.T_imu_cam0 : rig.T_imu_cam1)).inverse();
        const cv::Mat depth_mm =
            cv::imread((options.out / "truth" / ("cam" + std::to_string(index)) / "depth" /
                        (frames.back()[0] + ".png"))
                           .string(),
                       cv::IMREAD_UNCHANGED);
        ASSERT_EQ(depth_mm.type(), CV_16U);
        int num_on = 0;
        int num_before = 0;  // in front of all that the pixel and its neighbours see
        int num_all = 0;
        for (const Eigen::Vector3f& vertex : reference.vertices) {
            const Eigen::Vector3d p_cam = T_cam_world * vertex.cast<double>();
            const auto pixel = camera::project(camera, p_cam);
            if (!pixel || !camera::contains(camera, *pixel)) continue;
            const cv::Rect around = cv::Rect(static_cast<int>(std::lround(pixel->x())) - 1,
                                             static_cast<int>(std::lround(pixel->y())) - 1,
                                             3,
                                             3) &
                                    cv::Rect(0, 0, camera.width_px, camera.height_px);
            double nearest_mm = 0.0;
            double farthest_mm = 0.0;
            cv::minMaxLoc(depth_mm(around), &nearest_mm, &farthest_mm);
            ++num_all;
            const double z_mm = 1000.0 * p_cam.z();
            if (z_mm > 0.99 * nearest_mm && z_mm < 1.01 * farthest_mm) ++num_on;
            if (z_mm < 0.98 * nearest_mm) ++num_before;
        }
        ASSERT_GT(num_all, 500);
        EXPECT_GT(num_on, 0.8 * num_all);
        EXPECT_LT(num_before, 0.001 * num_all);
    }
}

TEST(SimulateTest, ALaterLapShowsTheSameImagesWithFreshStampsAndFreshNoise) {
    const TemporaryFolder folder;
    auto options = small_dive(folder / "dive");
    options.length_m = 1.2;
    options.rate_hz = 1.0;
    options.laps = 2;
    simulate(options);
    const auto frames = rows_of(options.out / "mav0/cam0/data.csv");
    ASSERT_EQ(frames.size() % 2, 0U);
    const std::size_t lap = frames.size() / 2;
    const auto image = [&](std::size_t i) {
        return content(options.out / "mav0/cam0/data" / frames[i][1]);
    };
    EXPECT_NE(frames[0][0], frames[lap][0]);
    EXPECT_TRUE(image(0) == image(lap));
    EXPECT_FALSE(image(0) == image(1));
    std::map<std::string, std::vector<std::string>> imu;
    for (const auto& row : rows_of(options.out / "mav0/imu0/data.csv")) imu[row[0]] = row;
    EXPECT_NE(imu.at(frames[1][0])[1], imu.at(frames[lap + 1][0])[1]);
    EXPECT_NEAR(std::stod(imu.at(frames[1][0])[4]), std::stod(imu.at(frames[lap + 1][0])[4]), 0.3);
}

TEST(SimulateTest, LaterYearTellsWhatChanged) {
    const TemporaryFolder folder;
    auto options = small_dive(folder / "dive");
    options.length_m = 0.1;
    options.rate_hz = 1.0;
    options.year = 2;
    simulate(options);
    const auto change = nlohmann::json::parse(content(options.out / "change.json"));
    EXPECT_EQ(change.at("to_year"), 2);
    EXPECT_FALSE(change.at("changes").empty());
    EXPECT_FALSE(change.at("surface").at("patches").empty());
}

TEST(SimulateTest, AnotherSurveyOfAYearTakesAnotherPathOverTheSamePlaceWithTheSameRig) {
    const TemporaryFolder folder;
    auto options = small_dive(folder / "first");
    simulate(options);
    options.out = folder / "second";
    options.survey = 2;
    simulate(options);
    const auto same = [&](const char* file) {
        return content(folder / "first" / file) == content(folder / "second" / file);
    };
    EXPECT_TRUE(same("measurements.json"));
    EXPECT_TRUE(same("mav0/cam0/sensor.yaml"));
    EXPECT_FALSE(same("mav0/state_groundtruth_estimate0/data.csv"));
    EXPECT_FALSE(std::filesystem::exists(options.out / "change.json"));
}

TEST(SimulateTest, DiveReaderFindsNothingWrongWithItAndReadsTheRigThatTookIt) {
    const TemporaryFolder folder;
    auto options = small_dive(folder / "dive");
    options.scene = SceneKind::Reef;
    simulate(options);
    const auto dive = dive::Dive::open(options.out, folder / "scratch");
    while (dive->next_frame()) continue;
    for (const Finding& finding : dive->findings())
        EXPECT_NE(finding.severity, Severity::Error) << finding.message;
    const types::Rig rig = draw_rig(options.width_px, options.height_px, options.seed);
    EXPECT_TRUE(dive->rig().T_imu_cam0.isApprox(rig.T_imu_cam0, 1e-9));
    EXPECT_TRUE(dive->rig().T_imu_cam1.isApprox(rig.T_imu_cam1, 1e-9));
    EXPECT_NEAR(dive->rig().cam1.fx_px, rig.cam1.fx_px, 1e-6);
    EXPECT_GT(dive->num_frames(), 1);
    EXPECT_FALSE(dive->ground_truth().empty());
    EXPECT_FALSE(dive->pressure().empty());
    EXPECT_GE(dive->known_distances().size(), 5U);
    EXPECT_TRUE(dive->read_reference_mesh().has_value());
}

TEST(SimulateTest, TransectIsADiveWithReferenceAndKnownLengths) {
    const TemporaryFolder folder;
    auto options = small_dive(folder / "dive");
    options.scene = SceneKind::Transect;
    options.length_m = 3.0;
    options.rate_hz = 1.0;
    simulate(options);
    const auto dive = dive::Dive::open(options.out, folder / "scratch");
    while (dive->next_frame()) continue;
    for (const Finding& finding : dive->findings())
        EXPECT_NE(finding.severity, Severity::Error) << finding.message;
    EXPECT_GE(dive->num_frames(), 10);
    EXPECT_FALSE(dive->known_distances().empty());
    ASSERT_TRUE(dive->read_reference_mesh().has_value());
    options.out = folder / "laps";
    options.laps = 2;
    EXPECT_THROW(simulate(options), Error);
    EXPECT_FALSE(fs::exists(options.out));
}

TEST(SimulateTest, CancellationLeavesThroughTheCallback) {
    const TemporaryFolder folder;
    const auto cancel = [](const Progress& progress) {
        if (progress.frames_done > 0) throw Error(ErrorCode::Cancelled, "enough");
    };
    EXPECT_THROW(simulate(small_dive(folder / "dive"), cancel), Error);
}

TEST(SimulateTest, CancellationIsHeardWhileTheSceneIsSetUp) {
    const TemporaryFolder folder;
    int num_calls = 0;
    const auto cancel = [&](const Progress&) {
        if (++num_calls == 5) throw Error(ErrorCode::Cancelled, "enough");
    };
    EXPECT_THROW(simulate(small_dive(folder / "dive"), cancel), Error);
    EXPECT_TRUE(fs::is_empty(folder / "dive/mav0/cam0/data"));
}

TEST(SimulateTest, BadOptionsAreRefusedBeforeAnythingIsWritten) {
    const TemporaryFolder folder;
    auto options = small_dive(folder / "dive");
    options.length_m = -1.0;
    EXPECT_THROW(simulate(options), Error);
    options.scene = SceneKind::Transect;
    options.length_m = 500.0;
    EXPECT_THROW(simulate(options), Error);
    EXPECT_FALSE(fs::exists(folder / "dive"));
    std::ofstream(folder / "something") << "here";
    EXPECT_THROW(simulate(small_dive(folder.path())), Error);
    EXPECT_THROW(scene_kind_from_string("volcano"), Error);
    EXPECT_THROW(water_kind_from_string("beer"), Error);
}

}  // namespace
}  // namespace divemesh::simulator
