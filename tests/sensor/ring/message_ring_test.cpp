#include "sensor/ring/message_ring.hpp"

#include <gtest/gtest.h>

#include <csignal>
#include <fstream>
#include <sched.h>
#include <sys/mount.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include "schemas/error.hpp"
#include "tests/temporary_folder.hpp"

namespace divemesh::sensor {
namespace {

namespace fs = std::filesystem;
using Pile = MessageRing::Pile;

constexpr std::int64_t kRoom = MessageRing::kMinBytes;

Message status(std::int64_t number) {
    Message message;
    message.uptime_ms = number;
    message.body = "{\"num_frames\":" + std::to_string(number) + "}";
    return message;
}

Message preview(std::size_t num_bytes) {
    Message message;
    message.kind = MessageKind::Preview;
    message.body = R"({"camera":"cam0"})";
    message.jpeg.assign(num_bytes, 'j');
    return message;
}

std::vector<std::string> waiting_in(MessageRing& ring, Pile pile = Pile::Texts) {
    std::vector<std::string> names;
    std::set<MessageRing::Key> seen;
    while (const auto key = ring.oldest(pile, seen)) {
        seen.insert(*key);
        const auto message = ring.read(*key);
        if (message) names.push_back(message->boot_id + "/" + std::to_string(message->sequence));
    }
    return names;
}

fs::path newest_segment(const fs::path& folder) {
    fs::path newest;
    for (const auto& entry : fs::directory_iterator(folder))
        if (entry.path().extension() == ".ring") newest = std::max(newest, entry.path());
    return newest;
}

using Names = std::vector<std::string>;

class MessageRingTest : public testing::Test {
protected:
    TemporaryFolder folder_;
};

TEST_F(MessageRingTest, KeepsWhatEarlierBootsSaid) {
    {
        MessageRing ring(folder_ / "ring", kRoom, "one");
        ring.append(status(1));
        ring.append(preview(1000));
        ring.append(status(2));
    }
    MessageRing ring(folder_ / "ring", kRoom, "two");
    EXPECT_EQ(ring.append(status(3)), 0);
    EXPECT_EQ(waiting_in(ring), (Names{"one/0", "one/2", "two/0"}));
    EXPECT_EQ(waiting_in(ring, Pile::Previews), Names{"one/1"});
    EXPECT_EQ(ring.newest(MessageKind::Preview), std::nullopt);
}

TEST_F(MessageRingTest, ForgetsWhatTheServerHasAlsoOverAStart) {
    {
        MessageRing ring(folder_ / "ring", kRoom, "one");
        for (int i = 0; i < 6; ++i) ring.append(status(i));
        ring.committed("one", {1, 3});
        ring.committed("other", {0, 5});
        EXPECT_EQ(waiting_in(ring), (Names{"one/0", "one/4", "one/5"}));
    }
    MessageRing ring(folder_ / "ring", kRoom, "two");
    EXPECT_EQ(waiting_in(ring), (Names{"one/0", "one/4", "one/5"}));
}

TEST_F(MessageRingTest, PowerLossAtAnyPointLosesTheLastMessageAtMost) {
    {
        MessageRing ring(folder_ / "ring", kRoom, "one");
        ring.append(status(1));
        ring.append(status(2));
    }
    const fs::path segment = newest_segment(folder_ / "ring");
    const auto size = fs::file_size(segment);
    for (std::uintmax_t cut = 1; cut < 56; ++cut) {
        fs::resize_file(segment, size - cut);
        MessageRing ring(folder_ / "ring", kRoom, "later");
        ASSERT_EQ(waiting_in(ring), Names{"one/0"}) << cut;
    }
    fs::resize_file(segment, 3);
    MessageRing ring(folder_ / "ring", kRoom, "later");
    EXPECT_EQ(waiting_in(ring), Names{});
}

// For every damaged byte, at most one message is lost. The loss is reported, except for the last
// record of a boot, which looks like a torn write.
TEST_F(MessageRingTest, LosesOneMessageAtMostToAFlippedByteAndTellsIt) {
    {
        MessageRing ring(folder_ / "ring", kRoom, "one");
        for (int i = 0; i < 6; ++i) ring.append(i % 3 == 1 ? preview(40) : status(i));
        ring.committed("one", {2, 2});
    }
    const fs::path segment = newest_segment(folder_ / "ring");
    std::ifstream stream(segment, std::ios::binary);
    const std::string whole{std::istreambuf_iterator<char>(stream), {}};
    for (std::size_t at = 0; at < whole.size(); ++at) {
        const TemporaryFolder damaged;
        std::string bytes = whole;
        bytes[at] = static_cast<char>(bytes[at] ^ 0x41);
        std::ofstream(damaged / segment.filename().string(), std::ios::binary) << bytes;
        MessageRing ring(damaged.path(), kRoom, "two");
        std::set<std::string> known;
        for (const Pile pile : {Pile::Texts, Pile::Previews})
            for (const std::string& name : waiting_in(ring, pile)) known.insert(name);
        const std::size_t num_waiting = known.size();
        for (const SequenceRange& range : ring.lost_of("one"))
            for (std::int64_t i = range.first; i <= range.last; ++i)
                known.insert("one/" + std::to_string(i));
        // 2 waits again when the word that it is committed is the one that is gone.
        ASSERT_GE(num_waiting, 4u) << at;
        for (const int i : {0, 1, 3, 4})
            ASSERT_TRUE(known.contains("one/" + std::to_string(i))) << at;
    }
}

TEST_F(MessageRingTest, DropsTheOldestAndTellsThem) {
    MessageRing ring(folder_ / "ring", kRoom, "one");
    for (int i = 0; i < 40; ++i) ring.append(preview(100'000));
    const auto kept = waiting_in(ring, Pile::Previews);
    ASSERT_GT(kept.size(), 15u);
    ASSERT_LT(kept.size(), 22u);
    EXPECT_EQ(kept.back(), "one/39");
    const auto lost = ring.lost();
    ASSERT_TRUE(lost);
    ASSERT_EQ(lost->ranges.size(), 1u);
    EXPECT_EQ(lost->ranges[0].first, 0);
    EXPECT_EQ(lost->ranges[0].last, 39 - static_cast<std::int64_t>(kept.size()));
    ring.reported_lost("one", lost->ranges);
    EXPECT_FALSE(ring.lost());
}

TEST_F(MessageRingTest, TellsWhatIsLostAlsoAfterAStart) {
    {
        MessageRing ring(folder_ / "ring", kRoom, "one");
        for (int i = 0; i < 60; ++i) ring.append(preview(100'000));
    }
    MessageRing ring(folder_ / "ring", kRoom, "two");
    const auto lost = ring.lost();
    ASSERT_TRUE(lost);
    EXPECT_EQ(lost->boot_id, "one");
    EXPECT_EQ(lost->ranges[0].first, 0);
    const auto kept = waiting_in(ring, Pile::Previews).size();
    EXPECT_EQ(lost->ranges[0].last, 59 - static_cast<std::int64_t>(kept));
}

TEST_F(MessageRingTest, StaysWithinItsRoom) {
    MessageRing ring(folder_ / "ring", kRoom, "one");
    for (int i = 0; i < 5000; ++i) {
        ring.append(status(i));
        if (i % 10 == 0) ring.append(preview(60'000));
        if (i % 3 == 0) ring.committed("one", {i, i});
    }
    std::uintmax_t size = 0;
    for (const auto& entry : fs::directory_iterator(folder_ / "ring")) size += entry.file_size();
    EXPECT_LT(size, static_cast<std::uintmax_t>(kRoom) + 20'000);
}

TEST_F(MessageRingTest, TakesSegmentsAwayThatTheServerHas) {
    MessageRing ring(folder_ / "ring", kRoom, "one");
    for (int i = 0; i < 15; ++i) ring.append(preview(100'000));
    ring.committed("one", {0, 14});
    int num_segments = 0;
    for (const auto& entry : fs::directory_iterator(folder_ / "ring"))
        num_segments += entry.path().extension() == ".ring" ? 1 : 0;
    EXPECT_LE(num_segments, 2);
    EXPECT_EQ(ring.num_waiting(), 0u);
}

TEST_F(MessageRingTest, GoesOnInMemoryWhenTheDiskIsFull) {
    signal(SIGXFSZ, SIG_IGN);
    MessageRing ring(folder_ / "ring", kRoom, "one");
    ring.append(status(0));
    rlimit before{};
    getrlimit(RLIMIT_FSIZE, &before);
    const rlimit none{0, before.rlim_max};
    setrlimit(RLIMIT_FSIZE, &none);
    ring.append(status(1));
    for (int i = 0; i < 50; ++i) ring.append(preview(100'000));
    ring.append(status(2));
    setrlimit(RLIMIT_FSIZE, &before);
    EXPECT_NE(ring.trouble(), "");
    EXPECT_EQ(waiting_in(ring), (Names{"one/0", "one/1", "one/52"}));
    EXPECT_LT(waiting_in(ring, Pile::Previews).size(), 43u);  // 4 MiB
    EXPECT_TRUE(ring.lost());
}

TEST_F(MessageRingTest, GoesOnInMemoryWhereNoFolderCanBe) {
    std::ofstream(folder_ / "file") << "no folder";
    MessageRing ring(folder_ / "file", kRoom, "one");
    ring.append(status(0));
    EXPECT_NE(ring.trouble(), "");
    ring.committed("one", {0, 0});
    EXPECT_EQ(ring.num_waiting(), 0u);
}

TEST_F(MessageRingTest, WritesAnewWhenItsFolderDisappears) {
    MessageRing ring(folder_ / "ring", kRoom, "one");
    ring.append(status(0));
    fs::remove_all(folder_ / "ring");
    ring.append(status(1));
    ring.sync();
    EXPECT_EQ(ring.trouble(), "");
    EXPECT_TRUE(fs::exists(newest_segment(folder_ / "ring")));
    EXPECT_EQ(waiting_in(ring), (Names{"one/0", "one/1"}));
}

// What the child process below says.
enum ReadOnly { kAsItShould, kNotAsItShould, kNoSuchDisk };

ReadOnly use_read_only(const fs::path& folder) {
    if (::unshare(CLONE_NEWUSER | CLONE_NEWNS) != 0) return kNoSuchDisk;
    const char* place = folder.c_str();
    if (::mount(place, place, nullptr, MS_BIND, nullptr) != 0) return kNoSuchDisk;
    if (::mount(nullptr, place, nullptr, MS_BIND | MS_REMOUNT | MS_RDONLY, nullptr) != 0)
        return kNoSuchDisk;
    MessageRing ring(folder, kRoom, "two");
    ring.append(status(0));
    ring.sync();
    if (waiting_in(ring) != Names{"one/0", "one/1", "two/0"} || ring.trouble().empty())
        return kNotAsItShould;
    ring.committed("one", {0, 1});
    ring.committed("two", {0, 0});
    return ring.num_waiting() == 0 ? kAsItShould : kNotAsItShould;
}

TEST_F(MessageRingTest, GoesOnInMemoryOnADiskThatCanOnlyBeRead) {
    {
        MessageRing ring(folder_ / "ring", kRoom, "one");
        ring.append(status(0));
        ring.append(status(1));
    }
    const pid_t child = ::fork();
    if (child == 0) ::_exit(use_read_only(folder_ / "ring"));
    int ended = 0;
    ASSERT_EQ(::waitpid(child, &ended, 0), child);
    ASSERT_TRUE(WIFEXITED(ended));
    if (WEXITSTATUS(ended) == kNoSuchDisk) GTEST_SKIP() << "this machine mounts nothing for us";
    EXPECT_EQ(WEXITSTATUS(ended), kAsItShould);
    MessageRing ring(folder_ / "ring", kRoom, "three");  // it could not note what was taken
    EXPECT_EQ(waiting_in(ring), (Names{"one/0", "one/1"}));
}

TEST_F(MessageRingTest, IsOfOneProcessAtATime) {
    MessageRing ring(folder_ / "ring", kRoom, "one");
    EXPECT_THROW(MessageRing(folder_ / "ring", kRoom, "two"), Error);
}

TEST_F(MessageRingTest, ReportsRefusedMessagesAsLost) {
    MessageRing ring(folder_ / "ring", kRoom, "one");
    ring.append(status(0));
    ring.refused(*ring.newest(MessageKind::Status));
    EXPECT_EQ(ring.num_waiting(), 0u);
    ASSERT_TRUE(ring.lost());
}

}  // namespace
}  // namespace divemesh::sensor
