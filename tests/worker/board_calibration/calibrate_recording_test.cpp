#include "worker/board_calibration/calibrate_recording.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <iterator>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <string>

#include "schemas/error.hpp"
#include "tests/temporary_folder.hpp"
#include "tests/worker/board_calibration/synthetic_boards.hpp"

namespace divemesh::board_calibration {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kNumPoses = 24;  // some 15 show the whole board to both cameras
constexpr double kNoise = 2.0;         // grey levels

// Returns the known rig with images of half the size.
RigParameters small_rig() {
    RigParameters rig = known_rig(types::Distortion::RadialTangential);
    for (LensKind* kind : {&rig.kind0, &rig.kind1}) {
        kind->width_px /= 2;
        kind->height_px /= 2;
    }
    for (LensValues* lens : {&rig.lens0, &rig.lens1})
        for (std::size_t i = 0; i < 4; ++i) (*lens)[i] /= 2.0;
    return rig;
}

void write_images(const fs::path& folder,
                  const types::Camera& camera,
                  const boards::Board& board,
                  const std::vector<Eigen::Isometry3d>& T_cam_board) {
    fs::create_directories(folder);
    const ImageRays rays(camera);
    cv::RNG random(7);
    for (std::size_t i = 0; i < T_cam_board.size(); ++i) {
        cv::Mat noisy;
        rendered_board(rays, board, T_cam_board[i]).convertTo(noisy, CV_16S);
        cv::Mat noise(noisy.size(), CV_16S);
        random.fill(noise, cv::RNG::NORMAL, 0.0, kNoise);
        noisy += noise;
        noisy.convertTo(noisy, CV_8U);
        const auto time_ns = std::to_string(1'000'000'000 + 500'000'000 * i);
        cv::imwrite((folder / (time_ns + ".png")).string(), noisy);
    }
}

void write_recording(const fs::path& folder, const RigParameters& rig) {
    std::mt19937_64 random(11);
    const boards::Board board = known_checkerboard();
    const auto T_cam0_board = drawn_poses(board, kNumPoses, random);
    std::vector<Eigen::Isometry3d> T_cam1_board;
    for (const auto& T : T_cam0_board) T_cam1_board.push_back(isometry_of(rig.T_cam1_cam0) * T);
    write_images(folder / "mav0/cam0/data", rig.cam0(), board, T_cam0_board);
    write_images(folder / "mav0/cam1/data", rig.cam1(), board, T_cam1_board);
}

TEST(CalibrateRecordingTest, FindsTheRigOfARenderedRecording) {
    const TemporaryFolder folder;
    const RigParameters truth = small_rig();
    write_recording(folder.path() / "recording", truth);
    std::ofstream(folder.path() / "board.yaml")
        << "target_type: 'checkerboard'\ntargetCols: 9\ntargetRows: 7\n"
           "rowSpacingMeters: 0.04\ncolSpacingMeters: 0.04\n";
    fs::create_directories(folder.path() / "scratch");
    CalibrationRequest request;
    request.recording = folder.path() / "recording";
    request.target = folder.path() / "board.yaml";
    request.out = folder.path() / "rig";
    request.scratch = folder.path() / "scratch";
    request.model = types::Distortion::RadialTangential;
    const auto document = calibrate_recording(request, base::ignore_progress);
    EXPECT_TRUE(document.at("usable").get<bool>()) << document.at("verdict");
    ASSERT_FALSE(document.contains("failure")) << document.at("failure");
    EXPECT_EQ(document.at("models")[0].at("model"), "radial-tangential");
    EXPECT_LT(document.at("corner_sigma_px").get<double>(), 0.1);
    for (int i = 0; i < truth.size(); ++i) {
        const auto& row = document.at("parameters")[static_cast<std::size_t>(i)];
        const double error = row.at("value").get<double>() - truth.vector()[i];
        // Allows four: of 22 parameters one is beyond three standard deviations in 6 % of draws.
        EXPECT_LT(std::abs(error), 4.0 * row.at("sigma").get<double>()) << row;
    }
    const double baseline_m = isometry_of(truth.T_cam1_cam0).translation().norm();
    EXPECT_NEAR(document.at("baseline_m").get<double>() / baseline_m, 1.0, 5e-4);
    std::ifstream page(request.out / "report.html");
    const std::string html{std::istreambuf_iterator<char>(page), {}};
    EXPECT_EQ(html.find("<!doctype html>"), 0U);
    EXPECT_EQ(html.find("<!doctype html>", 1), std::string::npos);
    EXPECT_NE(html.find(document.at("verdict").get<std::string>()), std::string::npos);
    EXPECT_TRUE(fs::exists(request.out / "calibration.json"));
    EXPECT_TRUE(fs::exists(request.out / "mav0/cam0/sensor.yaml"));
    EXPECT_TRUE(fs::exists(request.out / "mav0/cam1/sensor.yaml"));
    EXPECT_THROW(calibrate_recording(request, base::ignore_progress),
                 Error);  // `out` has a calibration already
}

}  // namespace
}  // namespace divemesh::board_calibration
