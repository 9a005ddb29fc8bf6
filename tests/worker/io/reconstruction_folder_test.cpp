#include "worker/io/reconstruction_folder.hpp"

#include <set>

#include "tests/worker/io/test_files.hpp"
#include "worker/io/ply.hpp"
#include "worker/io/trajectory_file.hpp"

namespace divemesh::io {
namespace {

class ReconstructionFolderTest : public FileTest {
protected:
    ReconstructionFolderTest() {
        write("metrics.json",
              R"({"calibration": {"T_imu_cam0": {"position_m": [0.1, 0, -0.2],
                  "orientation_wxyz": [0.70710678118, 0, 0, 0.70710678118]}}})");
        write("keyframes.json",
              R"({"keyframes": [{"frame_index": 7, "timestamp_ns": 1600000000000000001,
                  "position_m": [1, 2, 3], "orientation_wxyz": [1, 0, 0, 0]}]})");
    }

    ReconstructionFolder open() const { return ReconstructionFolder(file("")); }
};

TEST_F(ReconstructionFolderTest, GivesBackWhatWasWritten) {
    write_ply(file("mesh.ply"), tetrahedron());
    types::Trajectory trajectory(2);
    trajectory[1].timestamp_ns = 1'600'000'000'000'000'001;
    trajectory[1].T_world_imu.translation() = Eigen::Vector3d(1.5, -2.0, 0.25);
    write_tum(file("trajectory.tum"), trajectory);

    const ReconstructionFolder reconstruction = open();

    ASSERT_TRUE(reconstruction.has_surface());
    EXPECT_EQ(reconstruction.mesh().sigma_m, tetrahedron().sigma_m);
    EXPECT_EQ(reconstruction.trajectory()[1].timestamp_ns, 1'600'000'000'000'000'001);
    EXPECT_TRUE(reconstruction.trajectory()[1].T_world_imu.isApprox(trajectory[1].T_world_imu));
    const auto T_imu_cam0 = reconstruction.T_imu_cam0();
    ASSERT_TRUE(T_imu_cam0);
    // A rotation of 90 degrees about z.
    EXPECT_TRUE((*T_imu_cam0 * Eigen::Vector3d(1, 0, 0)).isApprox(Eigen::Vector3d(0.1, 1, -0.2)));
    ASSERT_EQ(reconstruction.keyframes().size(), 1U);
    EXPECT_EQ(reconstruction.keyframes()[0].timestamp_ns, 1'600'000'000'000'000'001);
    EXPECT_EQ(reconstruction.keyframes()[0].T_world_cam.translation(), Eigen::Vector3d(1, 2, 3));
}

TEST_F(ReconstructionFolderTest, TheSurfaceWasMatchedAtTheFocalLengthOfTheRectifiedImages) {
    write("metrics.json",
          R"({"calibration": {"focal_px": [900, 901]}, "frames": {"reduction": 2}})");
    write("keyframes.json", R"({"focal_px": 310.5, "keyframes": []})");
    EXPECT_EQ(open().matched_focal_px(), 310.5);
    std::filesystem::remove(file("keyframes.json"));
    EXPECT_EQ(open().matched_focal_px(), 450.0);
    write("metrics.json", "{}");
    EXPECT_EQ(open().matched_focal_px(), 0.0);
}

TEST_F(ReconstructionFolderTest, TheErrorOfSimplificationIsInSigmaAndIsNoNoise) {
    types::Mesh mesh = tetrahedron();
    mesh.sigma_m = {0.003F, 0.0F, 0.003F, 0.003F};  // 0: unknown
    write_ply(file("mesh.ply"), mesh);
    EXPECT_FALSE(open().is_simplified());
    EXPECT_EQ(open().mesh().sigma_m, mesh.sigma_m);
    write("metrics.json", R"({"mesh": {"simplification": {"rms_m": 0.004, "max_m": 0.03}}})");
    EXPECT_TRUE(open().is_simplified());
    EXPECT_NEAR(open().mesh().sigma_m[0], 0.005, 1e-7);
    EXPECT_EQ(open().mesh().sigma_m[1], 0.0F);
    EXPECT_EQ(open().mesh().sigma_local_m, mesh.sigma_local_m);
}

TEST_F(ReconstructionFolderTest, NamesWhatIsMissing) {
    const Error error = error_of([&] { open().trajectory(); });

    EXPECT_EQ(error.code(), ErrorCode::NotFound);
    EXPECT_NE(std::string(error.what()).find("trajectory.tum"), std::string::npos);
}

TEST_F(ReconstructionFolderTest, AFolderThatIsNoneSaysWhatToGive) {
    const Error error = error_of([&] { ReconstructionFolder(file("nowhere")); });

    EXPECT_EQ(error.code(), ErrorCode::NotFound);
    EXPECT_NE(std::string(error.what()).find("divemesh reconstruct --out"), std::string::npos);
}

TEST_F(ReconstructionFolderTest, AFieldOfAnotherTypeNamesItsFile) {
    write("keyframes.json", R"({"keyframes": [{"frame_index": "seven"}]})");

    const Error error = error_of([&] { open().keyframes(); });

    EXPECT_EQ(error.code(), ErrorCode::BadData);
    EXPECT_NE(std::string(error.what()).find("keyframes.json"), std::string::npos);
}

TEST_F(ReconstructionFolderTest, GivesTheSegmentsWithTheirFramesAndIntervals) {
    write("metrics.json", R"({"pieces": [
        {"num_frames": 3, "intervals": [{"first_ns": 10, "last_ns": 12}]},
        {"num_frames": 9, "intervals": [{"first_ns": 20, "last_ns": 24},
                                        {"first_ns": 40, "last_ns": 43}]}]})");

    const auto segments = open().segments();

    ASSERT_EQ(segments.size(), 2U);
    EXPECT_EQ(segments[1].num_frames, 9);
    EXPECT_TRUE(segments[1].contains(43));
    EXPECT_FALSE(segments[1].contains(30));
}

TEST_F(ReconstructionFolderTest, FilesOfOlderVersionsStateNoSegments) {
    EXPECT_TRUE(open().segments().empty());
}

TEST_F(ReconstructionFolderTest, ABrokenSegmentNamesItsFile) {
    write("metrics.json", R"({"pieces": [{"num_frames": "many"}]})");

    const Error error = error_of([&] { open().segments(); });

    EXPECT_EQ(error.code(), ErrorCode::BadData);
    EXPECT_NE(std::string(error.what()).find("metrics.json"), std::string::npos);
}

TEST_F(ReconstructionFolderTest, GivesTheVerdictAndTheFindings) {
    write("metrics.json", R"({"verdict": "not_usable", "restrictions": ["all"], "findings": [
        {"severity": "error", "code": "no_surface", "where": "", "message": "m", "remedy": "r"}]})");

    const ReconstructionFolder reconstruction = open();

    EXPECT_EQ(reconstruction.verdict(), Verdict::NotUsable);
    EXPECT_EQ(reconstruction.restrictions(), std::vector<std::string>{"all"});
    ASSERT_EQ(reconstruction.findings().size(), 1U);
    EXPECT_EQ(reconstruction.findings()[0].code, "no_surface");
}

TEST_F(ReconstructionFolderTest, FilesOfOlderVersionsStateNoVerdict) {
    EXPECT_FALSE(open().verdict());
    EXPECT_TRUE(open().restrictions().empty());
    EXPECT_TRUE(open().findings().empty());
}

TEST_F(ReconstructionFolderTest, AnUnknownVerdictNamesItsFile) {
    write("metrics.json", R"({"verdict": "splendid"})");

    const Error error = error_of([&] { open().verdict(); });

    EXPECT_EQ(error.code(), ErrorCode::BadData);
    EXPECT_NE(std::string(error.what()).find("metrics.json"), std::string::npos);
}

TEST_F(ReconstructionFolderTest, RemovesItsFilesAndKeepsAllOthers) {
    namespace fs = std::filesystem;
    fs::create_directories(file("keyframes"));
    fs::create_directories(file("accuracy"));
    fs::create_directories(file("mesh.glb"));  // not what a reconstruction writes
    for (const char* name : {"metrics.json",
                             "mesh.ply",
                             "mosaic_height.tif",
                             "heights.tif",
                             "keyframes/000012.jpg",
                             "keyframes/1234567.jpg",
                             "accuracy/report.json"})
        write(name, "old");
    const std::set<std::string> kept = {"notes.txt", "my_mesh.ply", "keyframes/best.jpg"};
    for (const std::string& name : kept) write(name, "kept");

    remove_reconstruction(file(""));

    const fs::path folder = file("notes.txt").parent_path();
    std::set<std::string> files;
    for (const auto& entry : fs::recursive_directory_iterator(folder))
        if (entry.is_regular_file()) files.insert(entry.path().lexically_relative(folder).string());
    EXPECT_EQ(files, kept);
    EXPECT_FALSE(fs::exists(file("accuracy")));
    EXPECT_TRUE(fs::is_directory(file("mesh.glb")));
    remove_reconstruction(file("nowhere"));
}

TEST_F(ReconstructionFolderTest, AFolderWithoutAResultKeepsAllFiles) {
    namespace fs = std::filesystem;
    fs::create_directories(file("keyframes"));
    for (const char* name : {"mesh.ply", "keyframes/20261127.jpg"}) write(name, "kept");
    fs::remove(file("metrics.json"));
    remove_reconstruction(file(""));
    EXPECT_TRUE(fs::exists(file("mesh.ply")));
    EXPECT_TRUE(fs::exists(file("keyframes/20261127.jpg")));
}

TEST_F(ReconstructionFolderTest, AQuaternionThatIsNoRotationIsRefused) {
    write("keyframes.json",
          R"({"keyframes": [{"frame_index": 7, "timestamp_ns": 1,
              "position_m": [1, 2, 3], "orientation_wxyz": [2, 0, 0, 0]}]})");

    EXPECT_EQ(error_of([&] { open().keyframes(); }).code(), ErrorCode::BadData);
}

}  // namespace
}  // namespace divemesh::io
