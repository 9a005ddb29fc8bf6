#include <gtest/gtest.h>

#include <fstream>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>

#include "tests/worker/recording/bag_writer.hpp"
#include "tests/worker/recording/import_fixture.hpp"
#include "tests/worker/recording/message_writer.hpp"
#include "tests/worker/video/video_writer.hpp"

namespace divemesh::recording {
namespace {

namespace fs = std::filesystem;

constexpr int kNumFrames = 10;
constexpr int kKeyEvery = 5;
constexpr std::int64_t kFirst_ns = 5'000'000'000;
constexpr std::int64_t kStep_ns = 100'000'000;

std::int64_t time_of(int frame) { return kFirst_ns + frame * kStep_ns; }

// Returns what camera 0 or 1 sees: a ramp whose brightness says which frame it is.
cv::Mat seen(int camera, int frame) {
    cv::Mat image(48, 64, CV_8UC3);
    for (int y = 0; y < image.rows; ++y)
        for (int x = 0; x < image.cols; ++x)
            image.at<cv::Vec3b>(y, x) =
                cv::Vec3b::all(static_cast<std::uint8_t>(40 + x + 12 * frame + 20 * camera));
    return image;
}

struct StreamCodec {
    const char* encoder;
    const char* extension;
    const char* format;  // as the messages name it
};
constexpr StreamCodec kH264{"libx264", ".h264", "h264"};
constexpr StreamCodec kH265{"libx265", ".hevc", "h265"};

class ImportVideoMessagesTest : public ImportFixture<RecordingImport, ImportOptions> {
protected:
    // Returns the access units of a camera's frames, as the encoder and the parser of FFmpeg give
    // them.
    std::vector<std::string> units_of(const StreamCodec& codec, int camera) {
        const fs::path file = folder_ / (std::string("stream") + codec.extension);
        video::WrittenVideo traits;
        traits.codec = codec.encoder;
        traits.pixel_format = "yuv420p";
        traits.encoder_options = {{"g", std::to_string(kKeyEvery)}, {"crf", "10"}};
        if (codec.encoder == std::string("libx265"))
            traits.encoder_options["x265-params"] =
                "log-level=none:pools=none:open-gop=0:bframes=0:scenecut=0";
        else
            traits.encoder_options["x264-params"] = "scenecut=0";
        video::VideoWriter writer(file, traits);
        for (int i = 0; i < kNumFrames; ++i) writer.add_frame(seen(camera, i), i * 100);
        writer.finish();
        return packets_of(file);
    }

    static std::vector<std::string> packets_of(const fs::path& file) {
        AVFormatContext* opened = nullptr;
        EXPECT_EQ(avformat_open_input(&opened, file.c_str(), nullptr, nullptr), 0);
        const video::FormatHandle format(opened);
        const video::PacketHandle packet = video::new_packet();
        std::vector<std::string> packets;
        while (av_read_frame(format.get(), packet.get()) >= 0) {
            packets.emplace_back(reinterpret_cast<const char*>(packet->data),
                                 static_cast<std::size_t>(packet->size));
            av_packet_unref(packet.get());
        }
        EXPECT_EQ(packets.size(), kNumFrames);
        return packets;
    }

    // A message as github.com/foxglove/foxglove-sdk, schemas/ros1 and ros2, describe it.
    std::string video_message(std::int64_t time_ns, const std::string& unit) const {
        return MessageWriter(wire_)
            .put(static_cast<std::uint32_t>(time_ns / 1'000'000'000))
            .put(static_cast<std::uint32_t>(time_ns % 1'000'000'000))
            .put_text("optical")
            .put_bytes(unit)
            .put_text(format_)
            .bytes();
    }

    std::string info_message(double shift_m) const {
        return camera_info_message(
            wire_,
            width_px_,
            48,
            "plumb_bob",
            {0, 0, 0, 0, 0},
            {std::vector<double>{60, 0, 31, 0, 60, 24, 0, 0, 1},
             std::vector<double>{1, 0, 0, 0, 1, 0, 0, 0, 1},
             std::vector<double>{60, 0, 31, -60 * shift_m, 0, 60, 24, 0, 0, 0, 1, 0}});
    }

    template <typename Writer>
    std::string recorded(Writer writer) {
        const auto add_topic = [&](std::uint16_t number,
                                   const std::string& name,
                                   const std::string& package,
                                   const std::string& type) {
            if constexpr (std::is_same_v<Writer, BagWriter>)
                writer.add_connection(number, name, package + "/" + type);
            else
                writer.add_channel(number, name, package + "/msg/" + type, "cdr");
        };
        add_topic(1, "/left/image_raw/foxglove", "foxglove_msgs", "CompressedVideo");
        add_topic(2, "/right/image_raw/foxglove", "foxglove_msgs", "CompressedVideo");
        add_topic(3, "/left/camera_info", "sensor_msgs", "CameraInfo");
        add_topic(4, "/right/camera_info", "sensor_msgs", "CameraInfo");
        writer.add_message(3, 1, info_message(0.0));
        writer.add_message(4, 2, info_message(0.1));
        for (std::size_t i = 0; i < left_.size(); ++i) {
            const std::int64_t time_ns = time_of(static_cast<int>(i));
            writer.add_message(1, time_ns, video_message(time_ns, left_[i]));
            writer.add_message(2, time_ns, video_message(time_ns, right_[i]));
        }
        return writer.finished();
    }

    ImportOptions written() {
        std::ofstream(folder_ / "recording", std::ios::binary)
            << (wire_ == Wire::Ros1 ? recorded(BagWriter()) : recorded(McapBytes("zstd")));
        ImportOptions options;
        options.recording = folder_ / "recording";
        options.out = folder_ / "dive";
        return options;
    }

    void encode(const StreamCodec& codec) {
        format_ = codec.format;
        left_ = units_of(codec, 0);
        right_ = units_of(codec, 1);
    }

    // Returns how far an image of the dive is from what was encoded, grey levels.
    double mean_difference(int camera, int frame) const {
        const std::string name = std::to_string(time_of(frame)) + ".png";
        const fs::path folder = folder_ / "dive/mav0" / ("cam" + std::to_string(camera)) / "data";
        const cv::Mat image = cv::imread((folder / name).string(), cv::IMREAD_COLOR);
        if (image.empty()) return 255.0;
        return cv::norm(image, seen(camera, frame), cv::NORM_L1) / (3.0 * 64 * 48);
    }

    Wire wire_ = Wire::LittleCdr;
    std::string format_;
    std::uint32_t width_px_ = 64;
    std::vector<std::string> left_;
    std::vector<std::string> right_;
};

TEST_F(ImportVideoMessagesTest, EveryFrameIsTheOneOfItsMessage) {
    for (const StreamCodec& codec : {kH264, kH265})
        for (const Wire wire : {Wire::Ros1, Wire::LittleCdr, Wire::BigCdr}) {
            wire_ = wire;
            encode(codec);
            fs::remove_all(folder_ / "dive");

            const ImportCounts counts = imported(written());

            EXPECT_EQ(counts.num_left, kNumFrames);
            EXPECT_EQ(counts.num_right, kNumFrames);
            EXPECT_FALSE(has_code("frames_damaged"));
            for (int i = 0; i < kNumFrames; ++i)
                for (const int camera : {0, 1})
                    EXPECT_LT(mean_difference(camera, i), 3.0) << codec.format << " frame " << i;
        }
}

TEST_F(ImportVideoMessagesTest, FramesBeforeTheFirstKeyFrameAreLeftOutAndTold) {
    encode(kH264);
    left_.erase(left_.begin());
    left_.push_back(left_.back());
    left_.back() = "no unit";

    const ImportCounts counts = imported(written());

    EXPECT_EQ(counts.num_left, kNumFrames - kKeyEvery);
    EXPECT_EQ(counts.num_right, kNumFrames);
    EXPECT_TRUE(has_code("frames_damaged"));
}

TEST_F(ImportVideoMessagesTest, ACodecThatIsNotReadIsNamed) {
    encode(kH264);
    format_ = "vp9";

    EXPECT_NE(refusal_of(written()).find("vp9"), std::string::npos);
}

TEST_F(ImportVideoMessagesTest, VideoOfAnotherSizeThanTheCalibrationIsRefused) {
    encode(kH264);
    width_px_ = 640;

    EXPECT_NE(refusal_of(written()).find("640"), std::string::npos);
}

TEST_F(ImportVideoMessagesTest, HostileUnitsAreLeftOut) {
    encode(kH265);
    left_[1].clear();
    left_[2].resize(left_[2].size() / 2);
    left_[3] = std::string(100'000, '\0');
    for (std::size_t i = 6; i < left_[6].size(); i += 3) left_[6][i] ^= 0x55;

    const ImportCounts counts = imported(written());

    EXPECT_GE(counts.num_left, 1);
    EXPECT_EQ(counts.num_right, kNumFrames);
    EXPECT_TRUE(has_code("message_unreadable"));
    EXPECT_TRUE(has_code("frames_damaged"));
}

}  // namespace
}  // namespace divemesh::recording
