// Images and videos in folders and archives, as they are uploaded.

#include <gtest/gtest.h>

#include <fstream>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "schemas/error.hpp"
#include "tests/temporary_folder.hpp"
#include "tests/worker/dive/test_archive.hpp"
#include "tests/worker/recording/import_fixture.hpp"
#include "tests/worker/video/video_writer.hpp"
#include "worker/dive/dive.hpp"
#include "worker/dive/refusal.hpp"
#include "worker/recording/recorded_dive.hpp"

namespace divemesh::recording {
namespace {

namespace fs = std::filesystem;
using dive::Container;
using dive::TestArchive;

constexpr int kNumPairs = 4;
constexpr std::int64_t kStart_ns = 1'700'000'000'000'000'000;
constexpr std::int64_t kPeriod_ns = 100'000'000;

cv::Mat made_image(int number, int type) {
    cv::Mat pixels(48, 64, type);
    cv::RNG random(static_cast<std::uint64_t>(number + 1));
    random.fill(pixels, cv::RNG::UNIFORM, 0, 256);
    return pixels;
}

class RecordedFilesTest : public testing::Test {
protected:
    fs::path put(const fs::path& file, const std::string& bytes) const {
        fs::create_directories((folder_ / file).parent_path());
        std::ofstream(folder_ / file, std::ios::binary) << bytes;
        return folder_ / file;
    }
    // Writes pairs of images whose names are their times, into folders of these names.
    void put_images(const fs::path& left, const fs::path& right) const {
        for (int i = 0; i < kNumPairs; ++i)
            for (const auto& [camera, number] : {std::pair(&left, 2 * i), {&right, 2 * i + 1}}) {
                std::vector<unsigned char> png;
                cv::imencode(".png", made_image(number, CV_8UC1), png);
                put(*camera / (std::to_string(kStart_ns + i * kPeriod_ns) + ".png"),
                    {png.begin(), png.end()});
            }
    }
    void put_video(const fs::path& file, int seed) const {
        fs::create_directories((folder_ / file).parent_path());
        video::VideoWriter writer(folder_ / file, {});
        for (int i = 0; i < kNumPairs; ++i)
            writer.add_frame(made_image(seed + i, CV_8UC3), 100 * i);
        writer.finish();
    }
    fs::path packed(const fs::path& folder,
                    const std::string& name,
                    Container container,
                    const std::string& prefix) const {
        TestArchive(folder_ / name, container).add_folder(folder_ / folder, prefix);
        return folder_ / name;
    }
    fs::path turned(const fs::path& recording) {
        return as_dive(recording,
                       folder_ / ("scratch" + std::to_string(num_turned_++)),
                       base::ignore_progress);
    }
    std::unique_ptr<dive::Dive> opened(const fs::path& recording) {
        const fs::path dive = turned(recording);
        EXPECT_NE(dive, recording);
        return dive::Dive::open(dive, folder_ / ("opened" + std::to_string(num_turned_)));
    }
    // Returns the code of the refusal; "" if there is none.
    std::string refusal_of(const fs::path& recording) {
        try {
            turned(recording);
        } catch (const dive::Refusal& refusal) {
            message_ = refusal.finding().message;
            return refusal.finding().code;
        }
        return "";
    }
    static bool tells(const dive::Dive& dive, const std::string& code) {
        for (const Finding& finding : dive.findings())
            if (finding.code == code) return true;
        return false;
    }

    TemporaryFolder folder_;
    std::string message_;  // of the last refusal
    int num_turned_ = 0;
};

TEST_F(RecordedFilesTest, ImagesWithKalibrsChainBesideThemAreADiveInAFolderAndInEveryArchive) {
    put_images("stills/left", "stills/right");
    put("stills/camchain-imucam.yaml", small_camchain("0.0"));
    put("stills/notes.txt", "a calm day");
    put("stills/left/._17.png", "of a Mac");
    for (const fs::path& recording : {folder_ / "stills",
                                      packed("stills", "a.zip", Container::Zip, "monday/"),
                                      packed("stills", "a.tar", Container::Tar, "./"),
                                      packed("stills", "a.tar.gz", Container::TarGz, ""),
                                      packed("stills", "a.tar.zst", Container::TarZst, "m/")}) {
        SCOPED_TRACE(recording);
        const auto dive = opened(recording);
        EXPECT_EQ(dive->num_frames(), kNumPairs);
        EXPECT_NEAR(dive->rig().baseline_m(), 0.1, 1e-12);
        EXPECT_TRUE(tells(*dive, "calibration_found"));
        EXPECT_EQ(dive->info().name, "");
        const auto frame = dive->frame(kNumPairs - 1);
        ASSERT_TRUE(frame);
        EXPECT_EQ(frame->timestamp_ns, kStart_ns + (kNumPairs - 1) * kPeriod_ns);
        const cv::Mat truth = made_image(2 * kNumPairs - 1, CV_8UC1);
        EXPECT_EQ(cv::norm(frame->right, truth, cv::NORM_INF), 0.0);
    }
}

TEST_F(RecordedFilesTest, TheSameArchiveIsTheSameDiveWhateverItIsCalled) {
    put_images("stills/left", "stills/right");
    put("stills/camchain.yaml", small_camchain("0.0"));
    const fs::path first = packed("stills", "a.zip", Container::Zip, "monday/");
    const fs::path second = folder_ / "0123abcd";
    fs::copy_file(first, second);
    EXPECT_EQ(opened(first)->content_sha256(), opened(second)->content_sha256());
}

TEST_F(RecordedFilesTest, VideosInAnArchiveAreADive) {
    put_video("videos/dive_left.mkv", 0);
    put_video("videos/dive_right.mkv", 100);
    put("videos/camchain.yaml", small_camchain("0.0"));
    for (const fs::path& recording :
         {folder_ / "videos", packed("videos", "v.zip", Container::Zip, "monday/")}) {
        SCOPED_TRACE(recording);
        const auto dive = opened(recording);
        EXPECT_EQ(dive->num_frames(), kNumPairs);
        EXPECT_EQ(dive->rig().cam0.width_px, 64);
        const cv::Mat right = dive->frame(0)->right;
        cv::Mat truth;
        cv::cvtColor(made_image(100, CV_8UC3), truth, cv::COLOR_BGR2GRAY);
        EXPECT_LT(cv::norm(right, truth, cv::NORM_INF), 3.0);
    }
    EXPECT_FALSE(fs::exists(folder_ / "scratch1/videos"));  // what was unpacked is gone
}

TEST_F(RecordedFilesTest, WhatIsMissingIsSaidWithTheWayOut) {
    put_images("stills/left", "stills/right");
    EXPECT_EQ(refusal_of(packed("stills", "a.zip", Container::Zip, "")), "recording_unclear");
    EXPECT_NE(message_.find("no calibration"), std::string::npos) << message_;

    put("stills/camchain.yaml", "cam0:\n  camera_model: pinhole\n  distortion_coeffs: [0]\n");
    EXPECT_EQ(refusal_of(packed("stills", "b.zip", Container::Zip, "")), "recording_unclear");
    EXPECT_NE(message_.find("camchain.yaml"), std::string::npos) << message_;

    put_images("unsided/port", "unsided/starboard");
    EXPECT_EQ(refusal_of(packed("unsided", "c.zip", Container::Zip, "")), "recording_unclear");

    put_video("one/left.mkv", 0);
    put("one/camchain.yaml", small_camchain("0.0"));
    EXPECT_EQ(refusal_of(packed("one", "d.zip", Container::Zip, "")), "recording_unclear");
}

TEST_F(RecordedFilesTest, ADiveIsLeftAsItIsAlsoIfItLacksItsCalibration) {
    put_images("dive/mav0/cam0/data", "dive/mav0/cam1/data");
    const fs::path without = packed("dive", "without.zip", Container::Zip, "monday/");
    EXPECT_EQ(turned(without), without);  // the dive says which files it lacks
    put("dive/photos/left/1.png", "of the boat");
    put("dive/mav0/cam0/sensor.yaml", "resolution: [64, 48]\n");
    for (const Container container : {Container::Zip, Container::TarGz}) {
        const fs::path archive = packed("dive", "native", container, "monday/");
        EXPECT_EQ(turned(archive), archive);
    }
    EXPECT_EQ(turned(folder_ / "dive"), folder_ / "dive");
}

TEST_F(RecordedFilesTest, HostileArchivesAreRefusedAsThoseOfDivesAre) {
    {
        TestArchive archive(folder_ / "up.zip", Container::Zip);
        archive.add("left/1.png", "x");
        archive.add("../right/1.png", "x");
    }
    EXPECT_EQ(refusal_of(folder_ / "up.zip"), "archive_entry_name");
    {
        TestArchive archive(folder_ / "bomb.tar.gz", Container::TarGz);
        archive.add("left/1.png", std::string(std::size_t{100} << 20U, '\0'));
        archive.add("right/1.png", "x");
    }
    const fs::path bomb = folder_ / "bomb.tar.gz";
    EXPECT_EQ(refusal_of(bomb), "archive_bomb");
}

}  // namespace
}  // namespace divemesh::recording
