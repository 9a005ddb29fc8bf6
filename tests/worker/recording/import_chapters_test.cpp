#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>

#include "tests/worker/recording/import_video_fixture.hpp"
#include "tests/worker/video/gpmf_writer.hpp"
#include "worker/recording/import_video.hpp"

namespace divemesh::recording {
namespace {

namespace fs = std::filesystem;

constexpr int kChapterFrames = 25;  // a second
constexpr int kPeriod_ms = 40;
constexpr int kPayloadSamples = 200;

std::vector<std::int64_t> times_ms(int num_frames) {
    std::vector<std::int64_t> times;
    for (int i = 0; i < num_frames; ++i) times.push_back(std::int64_t{kPeriod_ms} * i);
    return times;
}

// Telemetry of a second whose numbers tell which second it is.
std::string payload(int second, std::uint32_t num_until_here) {
    std::vector<int> gyro;
    std::vector<int> accel;
    for (int i = 0; i < kPayloadSamples; ++i) {
        gyro.insert(gyro.end(), {10, 20, kPayloadSamples * second + i});
        accel.insert(accel.end(), {981, second, 0});
    }
    return video::device(video::sensor_stream("GYRO", 100, "XYZ", num_until_here, gyro) +
                         video::sensor_stream("ACCL", 100, "XYZ", num_until_here, accel));
}

// Whether the camera counts the samples of its sensors on over chapters, or anew in each.
enum class Counting { On, Anew };

class ImportChaptersTest : public ImportVideoTest {
protected:
    // Writes seconds of one recording, from `first_s` on, as a file.
    fs::path seconds(const std::string& name,
                     int first_s,
                     int num_s,
                     video::WrittenVideo video,
                     int seed,
                     Counting counting = Counting::On) {
        video.rate_hz = 1000 / kPeriod_ms;
        std::vector<std::string> payloads;
        for (int i = 0; i < num_s && video.has_gpmf; ++i) {
            const int counted_s = counting == Counting::On ? first_s + i + 1 : i + 1;
            payloads.push_back(
                payload(first_s + i, static_cast<std::uint32_t>(kPayloadSamples * counted_s)));
        }
        return written(name,
                       times_ms(kChapterFrames * num_s),
                       seed + kChapterFrames * first_s,
                       video,
                       payloads);
    }

    // Returns the files of the last dive's sensors by their names below mav0.
    std::map<std::string, std::string> sensor_files() const {
        std::map<std::string, std::string> files;
        for (const auto& entry : fs::recursive_directory_iterator(folder_ / "dive" / "mav0"))
            if (entry.is_regular_file())
                files[fs::relative(entry.path(), folder_ / "dive" / "mav0").string()] =
                    text_of(entry.path());
        return files;
    }

    std::string message_of(const std::string& code) const {
        for (const Finding& finding : findings_)
            if (finding.code == code) return finding.message;
        return "";
    }
};

video::WrittenVideo lossless_h264() {
    video::WrittenVideo video;
    video.codec = "libx264";
    video.pixel_format = "yuv444p";
    video.max_b_frames = 2;
    video.encoder_options = {{"qp", "0"}, {"bf", "2"}};
    return video;
}

TEST_F(ImportChaptersTest, JoinedChaptersAreTheUncutVideoByStampAndPixel) {
    write_imu_yaml();
    video::WrittenVideo gopro;
    gopro.has_gpmf = true;
    for (const Counting counting : {Counting::On, Counting::Anew}) {
        const auto right = seconds("GX010456.MOV", 0, 1, {}, 500);
        seconds("GX020456.MOV", 1, 2, {}, 500);
        const auto whole = seconds("whole.MOV", 0, 3, gopro, 0);
        imported(options_for({whole, right}));
        const auto uncut = sensor_files();
        EXPECT_EQ(findings_.front().code, "video_chapters_joined");
        EXPECT_GT(uncut.at("imu0/data.csv").size(), 500U * 40U);
        const auto first = seconds("GX010123.MOV", 0, 1, gopro, 0);
        seconds("GX020123.MOV", 1, 1, gopro, 0, counting);
        seconds("GX030123.MOV", 2, 1, gopro, 0, counting);
        const ImportCounts counts = imported(options_for({first, right}));
        EXPECT_EQ(counts.num_left, 30);
        EXPECT_EQ(sensor_files(), uncut);
        EXPECT_NE(
            message_of("video_chapters_joined").find("GX010123.MOV, GX020123.MOV, GX030123.MOV"),
            std::string::npos);
        const auto info = nlohmann::json::parse(text_of(folder_ / "dive" / "dive.json"));
        EXPECT_EQ(info["name"], "GX010123");
        ASSERT_EQ(info["imported_from"]["files"].size(), 5U);
        EXPECT_EQ(info["imported_from"]["files"][1]["file"], "GX020123.MOV");
        EXPECT_EQ(info["imported_from"]["files"][1]["size_bytes"],
                  fs::file_size(folder_ / "GX020123.MOV"));
    }
}

TEST_F(ImportChaptersTest, ChaptersOfH264WithBFramesJoinWithoutAShift) {
    const auto video = lossless_h264();
    const auto right = seconds("r.MP4", 0, 2, video, 500);
    auto options = options_for({seconds("whole.MP4", 0, 2, video, 0), right});
    options.rate_hz = 100.0;
    EXPECT_EQ(imported(options).num_left, 2 * kChapterFrames);
    const auto uncut = sensor_files();
    options.videos[0] = seconds("GOPR0007.MP4", 0, 1, video, 0);
    seconds("GP010007.MP4", 1, 1, video, 0);
    imported(options);
    EXPECT_TRUE(has_code("video_chapters_joined"));
    EXPECT_EQ(sensor_files(), uncut);
}

TEST_F(ImportChaptersTest, SoundOfChaptersGivesTheOffset) {
    video::WrittenVideo video;
    video.audio_codec = "pcm_s16le";
    video.rate_hz = 1000 / kPeriod_ms;
    cv::RNG random(11);
    std::vector<float> sound(std::size_t{48'000} * 12);
    double loudness = 0.0;
    for (std::size_t i = 0; i < sound.size(); ++i) {
        if (i % 2400 == 0) loudness = random.uniform(0.02, 0.2);
        sound[i] = static_cast<float>(std::clamp(random.gaussian(loudness), -1.0, 1.0));
    }
    const auto heard = [&](const std::string& name, int begin_s, int end_s, int seed) {
        video::VideoWriter writer(folder_ / name, video);
        writer.add_sound({sound.begin() + 48'000 * begin_s, sound.begin() + 48'000 * end_s});
        for (int i = 0; i < kChapterFrames * (end_s - begin_s); ++i)
            writer.add_frame(noise_image(64, 48, seed + i), kPeriod_ms * i);
        writer.finish();
        return folder_ / name;
    };
    // No chapter of the left camera alone has enough sound.
    const auto left = heard("GH010001.MOV", 0, 3, 0);
    heard("GH020001.MOV", 3, 6, 0);
    heard("GH030001.MOV", 6, 9, 0);
    auto options = options_for({left, heard("r.MOV", 1, 12, 0)});
    options.offset_s.reset();
    imported(options);
    EXPECT_NE(message_of("video_offset").find("is 1.000"), std::string::npos)
        << message_of("video_offset");
}

TEST_F(ImportChaptersTest, AMissingChapterEndsTheRecording) {
    const auto right = seconds("r.MOV", 0, 4, {}, 500);
    const auto left = seconds("GX010123.MOV", 0, 1, {}, 0);
    seconds("GX030123.MOV", 2, 1, {}, 0);
    seconds("GX040123.MOV", 3, 1, {}, 0);
    EXPECT_EQ(imported(options_for({left, right})).num_left, 10);
    EXPECT_FALSE(has_code("video_chapters_joined"));
    ASSERT_TRUE(has_code("video_chapter_missing"));
    EXPECT_NE(message_of("video_chapter_missing").find("GX030123.MOV, GX040123.MOV"),
              std::string::npos);
    EXPECT_EQ(findings_.front().where, "GX020123.MOV");
}

TEST_F(ImportChaptersTest, ALaterChapterIsUsedAlone) {
    const auto right = seconds("r.MOV", 0, 4, {}, 500);
    seconds("GX010123.MOV", 0, 1, {}, 0);
    const auto left = seconds("GX020123.MOV", 1, 1, {}, 0);
    seconds("GX030123.MOV", 2, 1, {}, 0);
    EXPECT_EQ(imported(options_for({left, right})).num_left, 10);
    EXPECT_FALSE(has_code("video_chapters_joined"));
    EXPECT_NE(message_of("video_chapters_earlier").find("GX010123.MOV"), std::string::npos);
    expect_image("cam0", kUnknownStart_ns, noise_image(64, 48, kChapterFrames));
}

TEST_F(ImportChaptersTest, AChapterThatCannotFollowEndsTheRecording) {
    const auto right = seconds("r.MOV", 0, 3, {}, 500);
    const auto left = seconds("GX010123.MOV", 0, 1, {}, 0);
    seconds("GX030123.MOV", 2, 1, {}, 0);
    std::ofstream(folder_ / "GX020123.MOV") << "a camera that lost power";
    EXPECT_EQ(imported(options_for({left, right})).num_left, 10);
    EXPECT_TRUE(has_code("video_chapter_unusable"));
    video::WrittenVideo wide;
    wide.width_px = 128;
    seconds("GX020123.MOV", 1, 1, wide, 0);
    EXPECT_EQ(imported(options_for({left, right})).num_left, 10);
    EXPECT_TRUE(has_code("video_chapter_unusable"));
}

TEST_F(ImportChaptersTest, TwoChaptersAreNoPairOfCameras) {
    const auto first = seconds("GX010123.MOV", 0, 1, {}, 0);
    const auto second = seconds("GX020123.MOV", 1, 1, {}, 0);
    EXPECT_NE(refusal_of(options_for({first, second})).find("first chapter of each camera"),
              std::string::npos);
}

}  // namespace
}  // namespace divemesh::recording
