#include "worker/video/video_reader.hpp"

#include <gtest/gtest.h>

#include <fstream>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <sstream>

#include "schemas/error.hpp"
#include "tests/temporary_folder.hpp"
#include "tests/worker/video/video_writer.hpp"
#include "worker/video/video_index.hpp"

namespace divemesh::video {
namespace {

namespace fs = std::filesystem;

void no_progress(const Progress&) {}

// A noisy image that differs from every other one.
cv::Mat noise_image(int width_px, int height_px, int type, int seed) {
    cv::Mat image(height_px, width_px, type);
    cv::RNG random(static_cast<std::uint64_t>(seed + 1));
    random.fill(image, cv::RNG::UNIFORM, 0, 256);
    return image;
}

// A smooth image whose brightness tells its number.
cv::Mat plain_image(const WrittenVideo& video, int number) {
    return cv::Mat(video.height_px, video.width_px, CV_8UC3, cv::Scalar::all(8 + 8 * number));
}

class VideoReaderTest : public testing::Test {
protected:
    // Writes frames at times in ticks.
    fs::path written(const std::string& name,
                     const WrittenVideo& video,
                     const std::vector<std::int64_t>& ticks,
                     const std::function<cv::Mat(int)>& image) {
        VideoWriter writer(folder_ / name, video);
        for (std::size_t i = 0; i < ticks.size(); ++i)
            writer.add_frame(image(static_cast<int>(i)), ticks[i]);
        writer.finish();
        return folder_ / name;
    }

    static std::vector<VideoFrame> all_frames(const fs::path& path,
                                              const std::vector<std::int64_t>& stamps_ns,
                                              StoredJpeg jpeg = StoredJpeg::Decoded) {
        VideoReader reader(path, stamps_ns, jpeg);
        std::vector<VideoFrame> frames;
        while (auto frame = reader.next()) frames.push_back(std::move(*frame));
        return frames;
    }

    static std::string bytes_of(const fs::path& path) {
        std::ifstream stream(path, std::ios::binary);
        std::ostringstream text;
        text << stream.rdbuf();
        return text.str();
    }

    TemporaryFolder folder_;
};

TEST_F(VideoReaderTest, LosslessFramesOfUnevenStampsComeBackToTheByte) {
    const std::vector<std::int64_t> ticks = {0, 33, 66, 180, 181, 1000, 1033};
    for (const auto& [format, type] : {std::pair("bgr0", CV_8UC3), std::pair("gray", CV_8UC1)})
        for (const char* name : {"a.mkv", "a.mov", "a.avi"}) {
            const bool is_avi = std::string(name) == "a.avi";  // which has one rate
            WrittenVideo video;
            video.pixel_format = format;
            if (is_avi) video.ticks_hz = 30;
            const auto image = [&, t = type](int i) { return noise_image(64, 48, t, i); };
            const auto times = is_avi ? std::vector<std::int64_t>{0, 1, 2, 3, 4, 5, 6} : ticks;
            const fs::path path = written(name, video, times, image);
            const VideoIndex index = read_index(path, no_progress);
            ASSERT_EQ(index.stamps_ns.size(), times.size()) << name;
            EXPECT_FALSE(index.is_cut) << name;
            for (std::size_t i = 0; i < times.size(); ++i)
                EXPECT_NEAR(static_cast<double>(index.stamps_ns[i]),
                            1e9 * static_cast<double>(times[i]) / video.ticks_hz,
                            1.0)
                    << name;
            const auto frames = all_frames(path, index.stamps_ns);
            ASSERT_EQ(frames.size(), times.size()) << name;
            for (std::size_t i = 0; i < frames.size(); ++i) {
                EXPECT_EQ(frames[i].stamp_ns, index.stamps_ns[i]);
                ASSERT_EQ(frames[i].pixels.type(), type) << name;
                EXPECT_EQ(cv::norm(frames[i].pixels, image(static_cast<int>(i)), cv::NORM_INF), 0.0)
                    << name << i;
            }
        }
}

TEST_F(VideoReaderTest, ChosenFramesOfGroupsWithBFramesAreThoseOfTheirStamps) {
    for (const char* codec : {"libx264", "libx265", "mpeg4"}) {
        WrittenVideo video;
        video.codec = codec;
        video.pixel_format = "yuv420p";
        video.width_px = 128;
        video.height_px = 96;
        video.ticks_hz = 30;
        video.max_b_frames = 2;
        video.encoder_options = {{"g", "12"}};
        if (codec == std::string("libx265"))
            video.encoder_options["x265-params"] = "log-level=none";
        std::vector<std::int64_t> ticks;
        for (int i = 0; i < 30; ++i) ticks.push_back(i);
        const fs::path path =
            written("b.mp4", video, ticks, [&](int i) { return plain_image(video, i); });
        const VideoIndex index = read_index(path, no_progress);
        ASSERT_EQ(index.stamps_ns.size(), 30U) << codec;
        std::vector<std::int64_t> chosen_ns;
        for (std::size_t i = 0; i < 30; i += 3) chosen_ns.push_back(index.stamps_ns[i]);
        const auto frames = all_frames(path, chosen_ns);
        ASSERT_EQ(frames.size(), 10U) << codec;
        for (int i = 0; i < 10; ++i) {
            EXPECT_NEAR(static_cast<double>(frames[i].stamp_ns), 1e8 * i, 1.0) << codec;
            EXPECT_NEAR(cv::mean(frames[i].pixels)[1], 8 + 24 * i, 2.5) << codec << i;
        }
    }
}

TEST_F(VideoReaderTest, FramesOfMotionJpegStayTheFilesThatTheyAre) {
    WrittenVideo video;
    video.codec = "mjpeg";
    video.pixel_format = "yuvj420p";
    const fs::path path =
        written("a.avi", video, {0, 33, 66}, [](int i) { return noise_image(64, 48, CV_8UC3, i); });
    const auto stamps_ns = read_index(path, no_progress).stamps_ns;
    ASSERT_EQ(stamps_ns.size(), 3U);
    const std::string file = bytes_of(path);
    for (const VideoFrame& frame : all_frames(path, stamps_ns, StoredJpeg::Kept)) {
        ASSERT_FALSE(frame.jpeg.empty());
        EXPECT_NE(file.find(frame.jpeg), std::string::npos);
        const std::vector<char> bytes(frame.jpeg.begin(), frame.jpeg.end());
        EXPECT_EQ(cv::imdecode(bytes, cv::IMREAD_COLOR).size(), cv::Size(64, 48));
    }
    EXPECT_EQ(all_frames(path, stamps_ns, StoredJpeg::Kept).size(), 3U);
    EXPECT_EQ(all_frames(path, stamps_ns).at(2).pixels.size(), cv::Size(64, 48));
}

TEST_F(VideoReaderTest, ARotationIsDoneAndAMirrorRefused) {
    for (const int rotation_deg : {90, 180, 270}) {
        WrittenVideo video;
        video.rotation_deg = rotation_deg;
        const fs::path path =
            written("a.mov", video, {0}, [](int) { return noise_image(64, 48, CV_8UC3, 7); });
        const VideoIndex index = read_index(path, no_progress);
        ASSERT_EQ(index.traits.rotation_deg, rotation_deg);
        EXPECT_EQ(index.traits.upright_width_px(), rotation_deg == 180 ? 64 : 48);
        const cv::Mat image = noise_image(64, 48, CV_8UC3, 7);
        const cv::Mat turned = all_frames(path, index.stamps_ns).at(0).pixels;
        // Where the first pixel of the image goes when it is turned clockwise.
        const cv::Point corner = rotation_deg == 90    ? cv::Point(47, 0)
                                 : rotation_deg == 180 ? cv::Point(63, 47)
                                                       : cv::Point(0, 63);
        EXPECT_EQ(turned.at<cv::Vec3b>(corner), image.at<cv::Vec3b>(0, 0)) << rotation_deg;
    }
    WrittenVideo mirrored;
    mirrored.is_mirrored = true;
    const fs::path path =
        written("m.mov", mirrored, {0}, [](int) { return noise_image(64, 48, CV_8UC3, 7); });
    EXPECT_THROW(read_index(path, no_progress), Error);
}

TEST_F(VideoReaderTest, InterlacedVideoIsKnownAsSuch) {
    WrittenVideo video;
    video.codec = "mpeg4";
    video.pixel_format = "yuv420p";
    video.is_interlaced = true;
    const fs::path path =
        written("a.mkv", video, {0, 33}, [&](int i) { return plain_image(video, i); });
    EXPECT_TRUE(read_index(path, no_progress).traits.is_interlaced);
}

TEST_F(VideoReaderTest, ACutFileIsReadUpToTheCut) {
    for (const char* name : {"a.mkv", "a.mov"}) {
        WrittenVideo video;
        video.muxer_options = {{"movflags", "faststart"}};
        if (std::string(name) == "a.mkv") video.muxer_options.clear();
        std::vector<std::int64_t> ticks;
        for (int i = 0; i < 90; ++i) ticks.push_back(33 * i);
        const fs::path path =
            written(name, video, ticks, [](int i) { return noise_image(64, 48, CV_8UC3, i); });
        fs::resize_file(path, fs::file_size(path) / 2);
        const VideoIndex index = read_index(path, no_progress);
        EXPECT_TRUE(index.is_cut) << name;
        EXPECT_NEAR(static_cast<double>(index.stamps_ns.size()), 45.0, 4.0) << name;
        const auto frames = all_frames(path, index.stamps_ns);
        EXPECT_GE(frames.size() + 1, index.stamps_ns.size()) << name;
        EXPECT_EQ(cv::norm(frames[40].pixels, noise_image(64, 48, CV_8UC3, 40), cv::NORM_INF), 0.0);
    }
}

TEST_F(VideoReaderTest, WhatIsNoVideoIsRefusedWithWhatToDo) {
    std::string matroska("\x1A\x45\xDF\xA3", 4);
    matroska.append(200, 'x');
    const std::vector<std::string> contents = {"",
                                               "no video",
                                               "#EXTM3U\nfile:///etc/passwd\n",
                                               "ffconcat version 1.0\nfile /etc/passwd\n",
                                               std::string("\0\0\0\x18"
                                                           "ftypmp42\0\0\0\0mp42isom",
                                                           24),
                                               matroska,
                                               "RIFF\xFF\xFF\xFF\x7F"
                                               "AVI LIST"};
    for (const std::string& content : contents) {
        std::ofstream(folder_ / "bad", std::ios::binary) << content;
        try {
            read_index(folder_ / "bad", no_progress);
            ADD_FAILURE() << content;
        } catch (const Error& error) {
            EXPECT_GT(std::string(error.what()).size(), 60U) << error.what();
        }
    }
    EXPECT_THROW(read_index(folder_ / "missing", no_progress), Error);
    EXPECT_THROW(read_index(folder_.path(), no_progress), Error);
}

TEST_F(VideoReaderTest, EveryDamageOfAFileEndsInFramesOrAnError) {
    WrittenVideo video;
    video.codec = "libx264";
    video.pixel_format = "yuv420p";
    video.audio_codec = "aac";
    VideoWriter writer(folder_ / "a.mp4", video);
    writer.add_sound(std::vector<float>(9600, 0.1F));
    for (int i = 0; i < 10; ++i) writer.add_frame(noise_image(64, 48, CV_8UC3, i), 33 * i);
    writer.finish();
    const std::string whole = bytes_of(folder_ / "a.mp4");
    cv::RNG random(1);
    for (int trial = 0; trial < 150; ++trial) {
        std::string bytes = whole;
        for (int k = 0; k < 4; ++k)
            bytes[static_cast<std::size_t>(random.uniform(0, static_cast<int>(bytes.size())))] =
                static_cast<char>(random.uniform(0, 256));
        if (trial % 3 == 0) bytes.resize(bytes.size() / 10 * random.uniform(1, 10));
        std::ofstream(folder_ / "b.mp4", std::ios::binary) << bytes;
        try {
            const VideoIndex index = read_index(folder_ / "b.mp4", no_progress);
            EXPECT_LE(all_frames(folder_ / "b.mp4", index.stamps_ns).size(),
                      index.stamps_ns.size());
        } catch (const Error&) {
            continue;
        }
    }
}

}  // namespace
}  // namespace divemesh::video
