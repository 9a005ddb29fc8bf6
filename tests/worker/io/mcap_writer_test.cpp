#include "worker/io/mcap_writer.hpp"

#include <cstring>
#include <functional>

#include "schemas/base64.hpp"
#include "tests/worker/io/exported_folder.hpp"
#include "worker/io/crc32.hpp"
#include "worker/io/mcap_file.hpp"
#include "worker/io/trajectory_file.hpp"

namespace divemesh::io {
namespace {

using nlohmann::json;

std::uint64_t number_at(const std::string& bytes, std::size_t offset, std::size_t size_bytes) {
    std::uint64_t number = 0;
    std::memcpy(&number, bytes.data() + offset, size_bytes);
    return number;
}

std::uint32_t crc_of(const std::string& bytes) {
    Crc32 crc;
    crc.add(bytes);
    return crc.value();
}

// Calls `act` with opcode, content and place of each record, from a place on.
void for_each_record(const std::string& bytes,
                     std::size_t at,
                     const std::function<void(int, const std::string&, std::size_t)>& act) {
    while (at + 9 <= bytes.size()) {
        const std::size_t size = number_at(bytes, at + 1, 8);
        act(static_cast<unsigned char>(bytes[at]), bytes.substr(at + 9, size), at);
        at += 9 + size;
    }
}

class McapWriterTest : public ExportedFolderTest {
protected:
    static constexpr std::size_t kMagic_bytes = 8;

    static std::string without_magic(const std::string& bytes) {
        EXPECT_EQ(bytes.substr(0, kMagic_bytes), "\x89MCAP0\r\n");
        EXPECT_EQ(bytes.substr(bytes.size() - kMagic_bytes), "\x89MCAP0\r\n");
        return bytes.substr(0, bytes.size() - kMagic_bytes);
    }
};

TEST_F(McapWriterTest, TheChecksumIsThatOfThePublishedCheck) {
    EXPECT_EQ(crc_of("123456789"), 0xcbf43926U);
}

// The published layout: mcap.dev/spec.
TEST_F(McapWriterTest, ChecksumsAndIndicesAreThoseOfTheFormat) {
    McapFile writer(file("a.mcap"));
    const std::uint16_t a = writer.add_channel("/a", "A", {{"type", "object"}});
    const std::uint16_t b = writer.add_channel("/b", "B", {{"type", "object"}});
    const std::string large(3'000'000, 'x');  // two of them fill a chunk
    for (int i = 0; i < 5; ++i) writer.add_message(i % 2 == 0 ? a : b, 100 - i, {{"m", large}});
    writer.commit("name", {{"key", "value"}});
    const std::string bytes = without_magic(read(file("a.mcap")));
    int num_chunks = 0;
    int num_indexed = 0;
    for_each_record(
        bytes, kMagic_bytes, [&](int opcode, const std::string& content, std::size_t at) {
            if (opcode == 0x06) {
                ++num_chunks;
                const std::string records = content.substr(40);  // no compression
                EXPECT_EQ(number_at(content, 16, 8), records.size());
                EXPECT_EQ(number_at(content, 24, 4), crc_of(records));
            } else if (opcode == 0x08) {
                const std::size_t chunk_at = number_at(content, 16, 8);
                EXPECT_EQ(bytes[chunk_at], 0x06);
                EXPECT_EQ(number_at(bytes, chunk_at + 1, 8) + 9, number_at(content, 24, 8));
                EXPECT_EQ(content.substr(0, 16), bytes.substr(chunk_at + 9, 16));  // the times
                const std::size_t num_offsets = number_at(content, 32, 4) / 10;
                for (std::size_t i = 0; i < num_offsets; ++i) {
                    const std::size_t index_at = number_at(content, 36 + 10 * i + 2, 8);
                    EXPECT_EQ(bytes[index_at], 0x07);
                    const std::size_t num = number_at(bytes, index_at + 11, 4) / 16;
                    for (std::size_t k = 0; k < num; ++k) {
                        const std::size_t time = number_at(bytes, index_at + 15 + 16 * k, 8);
                        const std::size_t offset = number_at(bytes, index_at + 23 + 16 * k, 8);
                        const std::size_t message = chunk_at + 9 + 40 + offset;
                        EXPECT_EQ(bytes[message], 0x05);
                        EXPECT_EQ(number_at(bytes, message + 9 + 6, 8), time);
                        ++num_indexed;
                    }
                }
            } else if (opcode == 0x0f) {
                EXPECT_EQ(number_at(content, 0, 4), crc_of(bytes.substr(0, at)));
            } else if (opcode == 0x02) {
                const std::size_t summary_at = number_at(content, 0, 8);
                EXPECT_EQ(bytes[summary_at], 0x03);
                EXPECT_EQ(bytes[number_at(content, 8, 8)], 0x0e);
                EXPECT_EQ(number_at(content, 16, 4),
                          crc_of(bytes.substr(summary_at, at + 9 + 16 - summary_at)));
            } else if (opcode == 0x0e) {
                EXPECT_EQ(bytes[number_at(content, 1, 8)], content[0]);
            }
        });
    EXPECT_EQ(num_chunks, 3);
    EXPECT_EQ(num_indexed, 5);
}

TEST_F(McapWriterTest, AReconstructionHasItsPosesCloudAndKeyframes) {
    types::Trajectory path(2);
    path[0].timestamp_ns = keyframes_[0].timestamp_ns - 5;
    path[1].timestamp_ns = keyframes_[1].timestamp_ns;
    path[1].T_world_imu.translation() = Eigen::Vector3d(1.5, -2.0, 0.25);
    write_tum(file("trajectory.tum"), path);
    write_mcap(file("r.mcap"), open(), open().cloud(), "how good");
    const std::string bytes = without_magic(read(file("r.mcap")));
    std::vector<std::vector<json>> messages(5);
    for_each_record(bytes, kMagic_bytes, [&](int opcode, const std::string& chunk, std::size_t) {
        if (opcode != 0x06) return;
        for_each_record(chunk, 40, [&](int, const std::string& message, std::size_t) {
            messages.at(number_at(message, 0, 2)).push_back(json::parse(message.substr(22)));
        });
    });
    ASSERT_EQ(messages[0].size(), 2U);  // /pose
    EXPECT_EQ(messages[0][1]["pose"]["position"], (json{{"x", 1.5}, {"y", -2.0}, {"z", 0.25}}));
    EXPECT_EQ(messages[1].size(), 5U);  // /tf
    const std::string points = *decode_base64(messages[2].at(0)["data"].get<std::string>());
    EXPECT_EQ(points.size(), 3U * 16U);
    float x = 0.0F;
    std::memcpy(&x, points.data() + 16, sizeof x);
    EXPECT_EQ(x, 0.4F);
    EXPECT_EQ(points.substr(12, 4), "\x0a\x14\x1e\xff");
    ASSERT_EQ(messages[3].size(), 3U);  // /cam0/image
    EXPECT_EQ(*decode_base64(messages[3][1]["data"].get<std::string>()),
              read(file("keyframes/" + name_of(12))));
    // A point as ROS and Foxglove project it: pixel centres are whole numbers.
    const auto P = messages[4].at(0)["P"].get<std::array<double, 12>>();
    const Eigen::Vector3d p_cam = keyframes_[1].T_world_cam.inverse() * point_in_sight();
    const Eigen::Vector2d pixel(P[0] * p_cam.x() / p_cam.z() + P[2],
                                P[5] * p_cam.y() / p_cam.z() + P[6]);
    const Eigen::Vector2d from_center = small_pixel(1, point_in_sight()).array() - 0.5;
    EXPECT_LT((pixel - from_center).norm(), 1e-9);
}

}  // namespace
}  // namespace divemesh::io
