#include "worker/recording/db3_container.hpp"

#include <gtest/gtest.h>

#include <fstream>
#include <sstream>

#include "schemas/error.hpp"
#include "tests/temporary_folder.hpp"
#include "tests/worker/recording/bag_writer.hpp"
#include "tests/worker/recording/db3_writer.hpp"
#include "worker/recording/message_log.hpp"

namespace divemesh::recording {
namespace {

namespace fs = std::filesystem;

std::string content_of(const fs::path& file) {
    std::ifstream stream(file, std::ios::binary);
    std::ostringstream text;
    text << stream.rdbuf();
    return text.str();
}

void write_content(const fs::path& file, std::string_view bytes) {
    std::ofstream(file, std::ios::binary) << bytes;
}

class Db3ContainerTest : public testing::Test {
protected:
    // Returns "/topic@time: bytes" of every message.
    std::vector<std::string> read(const fs::path& path) {
        dive::FindingLog findings;
        std::vector<std::string> lines;
        {
            MessageLog log(path, findings);
            while (const auto message = log.next()) {
                std::string line = log.topics()[message->topic].name;
                line += '@' + std::to_string(message->log_time_ns);
                line += ": ";
                line += message->bytes;
                lines.push_back(line);
            }
        }
        findings_ = findings.all();
        return lines;
    }
    std::string refusal_of(const fs::path& path) {
        try {
            read(path);
        } catch (const Error& error) {
            return error.what();
        }
        ADD_FAILURE() << "it was not refused";
        return "";
    }
    bool has_code(const std::string& code) const {
        for (const Finding& finding : findings_)
            if (finding.code == code) return true;
        return false;
    }
    // Writes messages that are not in the order of time.
    static void add_messages(Db3Writer& writer, std::int64_t first_ns = 0) {
        writer.add_channel(7, "/imu", "sensor_msgs/msg/Imu");
        writer.add_channel(3, "/left", "sensor_msgs/msg/Image");
        writer.add_message(7, first_ns + 1, "one");
        writer.add_message(3, first_ns + 4, "four");
        writer.add_message(7, first_ns + 2, std::string("\0two", 4));
        writer.add_message(3, first_ns + 3, "");
    }
    static std::vector<std::string> in_order() {
        return {"/imu@1: one", std::string("/imu@2: \0two", 12), "/left@3: ", "/left@4: four"};
    }
    // Many messages of some pages each.
    fs::path large(int num_messages, int page_bytes) {
        const fs::path path = folder_ / "large.db3";
        Db3Writer writer(path, 4, page_bytes);
        writer.add_channel(1, "/left", "sensor_msgs/msg/Image");
        for (int i = 0; i < num_messages; ++i)
            writer.add_message(1, i, std::string(3000, static_cast<char>('a' + i % 26)));
        return path;
    }

    TemporaryFolder folder_;
    std::vector<Finding> findings_;
};

TEST_F(Db3ContainerTest, MessagesComeInTheOrderOfTimeInEveryVersionOfTheSchema) {
    for (int version = 1; version <= 4; ++version) {
        const fs::path path = folder_ / ("a?b#c%25d " + std::to_string(version) + ".db3");
        {
            Db3Writer writer(path, version);
            add_messages(writer);
        }
        EXPECT_EQ(read(path), in_order()) << version;
        EXPECT_TRUE(findings_.empty());
    }
}

TEST_F(Db3ContainerTest, MessagesThatAreCompressedOneByOneAreDecompressed) {
    const fs::path path = folder_ / "bag.db3";
    const std::string image(300'000, 'x');
    {
        Db3Writer writer(path);
        writer.add_channel(1, "/left", "sensor_msgs/msg/Image");
        writer.add_message(1, 1, packed("zstd", image));
        writer.add_message(1, 2, packed("zstd", image).substr(0, 20));
        writer.add_message(1, 3, packed("zstd", "three"));
    }
    EXPECT_EQ(read(path), (std::vector<std::string>{"/left@1: " + image, "/left@3: three"}));
    EXPECT_TRUE(has_code("recording_damaged"));
}

TEST_F(Db3ContainerTest, ALogThatACrashLeftIsReadAndNothingIsWritten) {
    const fs::path crashed = folder_ / "crashed";
    fs::create_directory(crashed);
    {
        Db3Writer writer(folder_ / "bag.db3");
        writer.run("COMMIT");
        writer.run("PRAGMA journal_mode = WAL");
        writer.run("BEGIN");
        add_messages(writer);
        writer.run("COMMIT");
        fs::copy_file(folder_ / "bag.db3", crashed / "bag.db3");
        fs::copy_file(folder_ / "bag.db3-wal", crashed / "bag.db3-wal");
        writer.run("BEGIN");
    }
    const std::string log = content_of(crashed / "bag.db3-wal");
    const std::string database = content_of(crashed / "bag.db3");
    ASSERT_FALSE(log.empty());
    EXPECT_EQ(read(crashed / "bag.db3"), in_order());
    EXPECT_TRUE(findings_.empty());
    EXPECT_EQ(content_of(crashed / "bag.db3-wal"), log);
    EXPECT_EQ(content_of(crashed / "bag.db3"), database);
    EXPECT_EQ(std::distance(fs::directory_iterator(crashed), fs::directory_iterator()), 2);
    // A log that is cut gives the transactions before the cut: here none, of an empty bag.
    fs::resize_file(crashed / "bag.db3-wal", log.size() - 100);
    EXPECT_NE(refusal_of(crashed / "bag.db3").find("no message"), std::string::npos);
}

TEST_F(Db3ContainerTest, ACutFileGivesWholeMessagesAndAWarning) {
    const fs::path path = large(60, 1024);
    const std::string whole = content_of(path);
    const auto all = read(path);
    ASSERT_EQ(all.size(), 60U);
    EXPECT_TRUE(findings_.empty());
    std::size_t most = 0;
    for (std::size_t size = 0; size < whole.size(); size += 2000) {
        write_content(path, std::string_view(whole).substr(0, size));
        try {
            const auto lines = read(path);
            EXPECT_TRUE(has_code("recording_cut")) << size;
            for (std::size_t i = 0; i < lines.size(); ++i)
                EXPECT_NE(std::find(all.begin(), all.end(), lines[i]), all.end()) << size;
            most = std::max(most, lines.size());
        } catch (const Error& error) {
            EXPECT_EQ(error.code(), ErrorCode::BadData) << error.what();
        }
    }
    EXPECT_GE(most, 55U);
}

TEST_F(Db3ContainerTest, ADamagedPageCostsItsMessagesAlone) {
    const fs::path path = large(60, 1024);
    const std::string whole = content_of(path);
    std::string bytes = whole;
    for (std::size_t i = 0; i < 1024; ++i) bytes[100 * 1024 + i] = '\xff';
    write_content(path, bytes);
    const auto lines = read(path);
    EXPECT_GE(lines.size(), 50U);
    EXPECT_LT(lines.size(), 60U + 1);
    EXPECT_EQ(lines.back().substr(0, 11), "/left@59: h");
}

TEST_F(Db3ContainerTest, EveryChangedByteIsSurvived) {
    const fs::path path = folder_ / "bag.db3";
    {
        Db3Writer writer(path, 1, 512);
        add_messages(writer);
    }
    const std::string whole = content_of(path);
    std::fstream file(path, std::ios::binary | std::ios::in | std::ios::out);
    for (std::size_t at = 0; at < whole.size(); ++at) {
        const char changed = static_cast<char>(whole[at] ^ (at % 2 == 0 ? '\xff' : '\x05'));
        file.seekp(static_cast<std::streamoff>(at)).put(changed).flush();
        try {
            EXPECT_LE(read(path).size(), 8U);
        } catch (const Error& error) {
            EXPECT_EQ(error.code(), ErrorCode::BadData) << error.what();
        }
        file.seekp(static_cast<std::streamoff>(at)).put(whole[at]).flush();
    }
    EXPECT_EQ(read(path), in_order());
}

// An inner page of the tree whose children are all one page: its rows come again and again.
TEST_F(Db3ContainerTest, PagesThatReferToEachOtherEnd) {
    const fs::path path = large(3000, 512);
    const std::string whole = content_of(path);
    int num_inner = 0;
    std::string bytes = whole;
    for (std::size_t page = 512; page < bytes.size(); page += 512) {
        if (bytes[page] != '\x05') continue;  // an inner page of a table
        const auto byte = [&](std::size_t at) {
            return static_cast<unsigned char>(bytes[page + at]);
        };
        const std::size_t num_cells = static_cast<std::size_t>(byte(3)) * 256 + byte(4);
        const std::size_t first = static_cast<std::size_t>(byte(12)) * 256 + byte(13);
        if (num_cells < 2 || num_cells > 100 || first > 508) continue;
        ++num_inner;
        for (std::size_t i = 1; i < num_cells; ++i) {
            const std::size_t cell =
                static_cast<std::size_t>(byte(12 + 2 * i)) * 256 + byte(13 + 2 * i);
            if (cell <= 508) bytes.replace(page + cell, 4, bytes.substr(page + first, 4));
        }
    }
    ASSERT_GT(num_inner, 10);
    write_content(path, bytes);
    EXPECT_LT(read(path).size(), 3000U);
    EXPECT_TRUE(has_code("recording_damaged"));
}

TEST_F(Db3ContainerTest, ASchemaWithCodeIsRefused) {
    int number = 0;
    for (const char* sql : {"CREATE VIEW a AS SELECT 1",
                            "CREATE TRIGGER a AFTER INSERT ON topics BEGIN SELECT 1; END",
                            "DROP TABLE messages",
                            "DROP TABLE topics",
                            "DROP TABLE messages; CREATE VIEW messages AS SELECT 1 AS topic_id, 2 "
                            "AS timestamp, zeroblob(100000000) AS data",
                            "DROP TABLE messages; CREATE TABLE messages(topic_id, timestamp, data "
                            "AS (zeroblob(100000000)))",
                            "DROP TABLE messages; CREATE TABLE messages(rowid, topic_id, "
                            "timestamp, data)",
                            "DROP TABLE messages; CREATE TABLE messages(topic_id PRIMARY KEY, "
                            "timestamp, data) WITHOUT ROWID"}) {
        const fs::path path = folder_ / (std::to_string(++number) + ".db3");
        {
            Db3Writer writer(path);
            add_messages(writer);
            writer.run("COMMIT");
            writer.run(sql);
            writer.run("BEGIN");
        }
        EXPECT_NE(refusal_of(path).find("is no ROS 2 bag"), std::string::npos) << sql;
    }
}

TEST_F(Db3ContainerTest, RowsThatNoRecorderWritesAreLeftOut) {
    const fs::path path = folder_ / "bag.db3";
    {
        Db3Writer writer(path);
        add_messages(writer);
        writer.run("INSERT INTO messages VALUES (-5, 7, 1, x'00')");
        writer.run("INSERT INTO messages VALUES (100, 7, -1, x'00')");
        writer.run("INSERT INTO messages VALUES (101, 7, 1, 'text')");
        writer.run("INSERT INTO messages VALUES (102, 1000, 1, x'00')");
        writer.run("INSERT INTO messages VALUES (9223372036854775807, 7, 1, x'00')");
    }
    EXPECT_EQ(read(path), in_order());
}

TEST_F(Db3ContainerTest, TheFilesOfAFolderAreOneRecording) {
    const fs::path bag = folder_ / "bag";
    fs::create_directory(bag);
    for (int i = 0; i < 3; ++i) {
        Db3Writer writer(bag / ("bag_" + std::to_string(i) + ".db3"));
        add_messages(writer, 10 * i);
    }
    write_content(bag / "bag_1.db3.zstd", packed("zstd", content_of(bag / "bag_1.db3")));
    fs::remove(bag / "bag_1.db3");
    write_content(bag / "bag_3.db3", "no database");
    write_content(bag / "metadata.yaml",
                  "rosbag2_bagfile_information:\n  relative_file_paths:\n    - bag_0.db3\n    - "
                  "bag/bag_1.db3\n    - bag_9.db3\n");
    const auto lines = read(bag);
    ASSERT_EQ(lines.size(), 12U);
    EXPECT_EQ(lines[4], "/imu@11: one");
    EXPECT_EQ(lines[11], "/left@24: four");
    ASSERT_EQ(findings_.size(), 2U);
    EXPECT_EQ(findings_[0].code, "recording_part_missing");
    EXPECT_EQ(findings_[0].where, "bag_9.db3");
    EXPECT_EQ(findings_[1].code, "recording_part_unreadable");
    fs::create_directory(folder_ / "empty");
    EXPECT_NE(refusal_of(folder_ / "empty").find("ros2 bag record"), std::string::npos);
}

TEST_F(Db3ContainerTest, ACompressedFileThatIsCutGivesItsBeginning) {
    const fs::path path = large(60, 1024);
    std::string noise = content_of(path);
    const std::string whole = packed("zstd", noise);
    const fs::path compressed = folder_ / "large.db3.zstd";
    write_content(compressed, whole);
    EXPECT_EQ(read(compressed).size(), 60U);
    EXPECT_TRUE(findings_.empty());
    for (std::size_t size = 4; size < whole.size(); size += whole.size() / 7) {
        write_content(compressed, std::string_view(whole).substr(0, size));
        try {
            EXPECT_LT(read(compressed).size(), 60U);
            EXPECT_TRUE(has_code("recording_cut"));
        } catch (const Error& error) {
            EXPECT_EQ(error.code(), ErrorCode::BadData) << error.what();
        }
    }
}

TEST_F(Db3ContainerTest, ACompressedBombIsRefused) {
    write_content(folder_ / "bomb.db3.zstd",
                  packed("zstd", std::string(std::size_t{80} << 20U, '\0')));
    try {
        read(folder_ / "bomb.db3.zstd");
        ADD_FAILURE() << "it was not refused";
    } catch (const Error& error) {
        EXPECT_EQ(error.code(), ErrorCode::TooLarge);
    }
}

}  // namespace
}  // namespace divemesh::recording
