#include "worker/recording/message_log.hpp"

#include <gtest/gtest.h>

#include "schemas/error.hpp"
#include "tests/worker/recording/bag_writer.hpp"
#include "tests/worker/recording/memory_file.hpp"
#include "worker/recording/unpack.hpp"

namespace divemesh::recording {
namespace {

struct ReadBack {
    std::vector<std::string> messages;  // "/topic@time: bytes"
    std::vector<Finding> findings;
};

class MessageLogTest : public testing::Test {
protected:
    ReadBack read(const std::string& bytes) {
        const MemoryFile file(bytes);
        dive::FindingLog findings;
        MessageLog log(file.path(), findings);
        ReadBack result;
        while (const auto message = log.next()) {
            std::string line = log.topics()[message->topic].name;
            line += '@';
            line += std::to_string(message->log_time_ns);
            line += ": ";
            line += message->bytes;
            result.messages.push_back(line);
        }
        EXPECT_EQ(log.num_messages(), std::ssize(result.messages));
        result.findings = findings.all();
        return result;
    }

    // Two chunks whose times overlap, so that their messages have to be merged.
    template <typename Writer>
    static std::string two_chunks(Writer writer, const std::string& filling = "") {
        writer.add_message(1, 1'000'000'000, "one" + filling);
        writer.add_message(2, 4'000'000'000, "four");
        writer.end_chunk();
        writer.add_message(1, 2'000'000'001, "two");
        writer.add_message(2, 3'000'000'000, "three");
        return writer.finished();
    }
    static std::string bag(const std::string& codec, const std::string& filling = "") {
        BagWriter writer(codec);
        writer.add_connection(1, "/imu", "sensor_msgs/Imu");
        writer.add_connection(2, "/left", "sensor_msgs/Image");
        return two_chunks(std::move(writer), filling);
    }
    static std::string mcap(const std::string& codec, const std::string& filling = "") {
        McapBytes writer(codec);
        writer.add_channel(1, "/imu", "sensor_msgs/msg/Imu", "cdr");
        writer.add_channel(2, "/left", "sensor_msgs/msg/Image", "cdr");
        return two_chunks(std::move(writer), filling);
    }
    static std::vector<std::string> in_order(const std::string& filling = "") {
        return {"/imu@1000000000: one" + filling,
                "/imu@2000000001: two",
                "/left@3000000000: three",
                "/left@4000000000: four"};
    }
    static bool has_code(const ReadBack& result, const std::string& code) {
        for (const Finding& finding : result.findings)
            if (finding.code == code) return true;
        return false;
    }
};

TEST_F(MessageLogTest, MessagesOfABagComeInTheOrderOfTimeWhateverItsCompression) {
    const std::string filling(3'000'000, 'x');
    for (const char* codec : {"none", "lz4", "bz2"}) {
        const ReadBack result = read(bag(codec, filling));
        EXPECT_EQ(result.messages, in_order(filling)) << codec;
        EXPECT_TRUE(result.findings.empty()) << codec;
    }
}

TEST_F(MessageLogTest, MessagesOfMcapComeInTheOrderOfTimeWhateverItsCompression) {
    const std::string filling(3'000'000, 'x');
    for (const char* codec : {"", "lz4", "zstd", "outside"}) {
        const ReadBack result = read(mcap(codec, filling));
        EXPECT_EQ(result.messages, in_order(filling)) << codec;
        EXPECT_TRUE(result.findings.empty()) << codec;
    }
}

TEST_F(MessageLogTest, TypesOfRos2AreNamedAsThoseOfRos1) {
    const MemoryFile file(mcap("lz4"));
    dive::FindingLog findings;
    const MessageLog log(file.path(), findings);
    ASSERT_EQ(log.topics().size(), 2U);
    EXPECT_EQ(log.topics()[0].type, "sensor_msgs/Imu");
    EXPECT_EQ(log.topics()[0].serialization, Serialization::Cdr);
    EXPECT_EQ(log.topics()[0].num_messages, 2);
}

TEST_F(MessageLogTest, ACutFileGivesWhatIsBeforeTheCutAndAWarning) {
    for (const std::string& whole : {bag("none"),
                                     bag("lz4"),
                                     bag("bz2"),
                                     mcap(""),
                                     mcap("lz4"),
                                     mcap("zstd"),
                                     mcap("outside")}) {
        std::size_t most = 0;
        for (std::size_t size = 0; size <= whole.size(); ++size) {
            try {
                const ReadBack result = read(whole.substr(0, size));
                EXPECT_GE(result.messages.size(), most) << size;
                most = std::max(most, result.messages.size());
            } catch (const Error& error) {
                EXPECT_EQ(error.code(), ErrorCode::BadData);
                EXPECT_EQ(most, 0U) << size << ": " << error.what();
            }
        }
        EXPECT_EQ(most, 4U);
    }
    EXPECT_TRUE(has_code(read(mcap("lz4").substr(0, mcap("lz4").size() - 30)), "recording_cut"));
    EXPECT_TRUE(has_code(read(bag("none").substr(0, bag("none").size() - 1)), "recording_cut"));
}

TEST_F(MessageLogTest, EveryChangedByteIsSurvived) {
    for (const std::string& whole : {bag("none"),
                                     bag("lz4"),
                                     bag("bz2"),
                                     mcap(""),
                                     mcap("lz4"),
                                     mcap("zstd"),
                                     mcap("outside")})
        for (std::size_t at = 0; at < whole.size(); ++at)
            for (const char change : {'\x01', '\x80', '\xff'}) {
                std::string bytes = whole;
                bytes[at] = static_cast<char>(bytes[at] ^ change);
                try {
                    EXPECT_LE(read(bytes).messages.size(), 4U);
                } catch (const Error& error) {
                    EXPECT_EQ(error.code(), ErrorCode::BadData) << error.what();
                }
            }
}

TEST_F(MessageLogTest, AChunkWithAWrongChecksumIsLeftOutAlone) {
    McapBytes writer("zstd");
    writer.add_channel(1, "/imu", "sensor_msgs/msg/Imu", "cdr");
    writer.add_message(1, 1, "good");
    writer.end_chunk();
    writer.add_message(1, 2, "bad");
    writer.end_chunk(-1, 1);
    writer.add_message(1, 3, "good again");
    const ReadBack result = read(writer.finished());
    EXPECT_EQ(result.messages, (std::vector<std::string>{"/imu@1: good", "/imu@3: good again"}));
    ASSERT_TRUE(has_code(result, "recording_damaged"));
    EXPECT_EQ(result.findings.front().message, "the checksum of a chunk is wrong");
}

TEST_F(MessageLogTest, AChunkThatClaimsATerabyteIsLeftOutAlone) {
    for (const char* codec : {"", "lz4", "zstd"}) {
        McapBytes writer(codec);
        writer.add_channel(1, "/imu", "sensor_msgs/msg/Imu", "cdr");
        writer.add_message(1, 1, "good");
        writer.end_chunk();
        writer.add_message(1, 2, "bad");
        writer.end_chunk(std::int64_t{1} << 40);
        const ReadBack result = read(writer.finished());
        EXPECT_EQ(result.messages, (std::vector<std::string>{"/imu@1: good"}));
        EXPECT_TRUE(has_code(result, "recording_damaged"));
    }
    BagWriter bag("lz4");
    bag.add_connection(1, "/imu", "sensor_msgs/Imu");
    bag.add_message(1, 1, "good");
    bag.end_chunk();
    bag.add_message(1, 2, "bad");
    bag.end_chunk(0xffff'ffff);
    EXPECT_TRUE(has_code(read(bag.finished()), "recording_damaged"));
}

// Each chunk is far below the limit of a block; together they are 80 MiB of some kilobytes.
TEST_F(MessageLogTest, ManyChunksThatUnpackToTooMuchAreRefusedAsABomb) {
    const std::string zeros(std::size_t{4} << 20U, '\0');
    BagWriter bag("bz2");
    McapBytes mcap("zstd");
    bag.add_connection(1, "/imu", "sensor_msgs/Imu");
    mcap.add_channel(1, "/imu", "sensor_msgs/msg/Imu", "cdr");
    for (int i = 0; i < 20; ++i) {
        bag.add_message(1, i, zeros);
        bag.end_chunk();
        mcap.add_message(1, i, zeros);
        mcap.end_chunk();
    }
    for (const std::string& bytes : {bag.finished(), mcap.finished()}) {
        EXPECT_LT(bytes.size(), 100'000U);
        try {
            read(bytes);
            ADD_FAILURE() << "it was not refused";
        } catch (const Error& error) {
            EXPECT_EQ(error.code(), ErrorCode::TooLarge);
            EXPECT_NE(std::string(error.what()).find("bomb"), std::string::npos);
        }
    }
}

TEST(UnpackTest, ABombIsToldBySizeAndRatio) {
    constexpr std::int64_t kMiB = 1 << 20;
    EXPECT_FALSE(is_bomb(64 * kMiB, 100));  // small, whatever the ratio
    EXPECT_TRUE(is_bomb(65 * kMiB, 100));
    EXPECT_FALSE(is_bomb(1000 * kMiB, 10 * kMiB));
    EXPECT_TRUE(is_bomb(1000 * kMiB + 100, 10 * kMiB));
    EXPECT_FALSE(is_bomb(512 * 1024 * kMiB, 500 * 1024 * kMiB));
    EXPECT_TRUE(is_bomb(512 * 1024 * kMiB + 1, 500 * 1024 * kMiB));
}

TEST_F(MessageLogTest, ALengthOf2To63EndsTheRecordingThere) {
    McapBytes writer("outside");
    writer.add_channel(1, "/imu", "sensor_msgs/msg/Imu", "cdr");
    writer.add_message(1, 1, "good");
    writer.end_chunk();
    std::string bytes = writer.finished();
    bytes.resize(bytes.size() - 50);  // DataEnd, Footer and the magic bytes
    for (const std::uint64_t length : {std::uint64_t{1} << 63, ~std::uint64_t{0}}) {
        const ReadBack result = read(bytes + TestBytes().put('\x05').put(length).bytes + "rest");
        EXPECT_EQ(result.messages, (std::vector<std::string>{"/imu@1: good"}));
        EXPECT_TRUE(has_code(result, "recording_cut"));
    }
}

TEST_F(MessageLogTest, OtherFilesAreRefusedWithWhatToDo) {
    for (const auto& [bytes, advice] : std::vector<std::pair<std::string, std::string>>{
             {"", "give an MCAP file"},
             {"SQLite format 3 and more", "give an MCAP file"},
             {"#ROSBAG V1.2\nand more", "rosbag migrate"},
             {"PK\x03\x04 a zip archive", "give an MCAP file"}})
        try {
            read(bytes);
            ADD_FAILURE() << bytes;
        } catch (const Error& error) {
            EXPECT_NE(std::string(error.what()).find(advice), std::string::npos) << error.what();
        }
}

}  // namespace
}  // namespace divemesh::recording
