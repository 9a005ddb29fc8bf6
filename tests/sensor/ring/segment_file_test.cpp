#include "sensor/ring/segment_file.hpp"

#include <gtest/gtest.h>

#include <csignal>
#include <fstream>
#include <string>
#include <sys/resource.h>
#include <vector>

#include "schemas/error.hpp"
#include "tests/temporary_folder.hpp"

namespace divemesh::sensor {
namespace {

using Payloads = std::vector<std::string>;

Payloads payloads_in(const std::filesystem::path& path) {
    Payloads payloads;
    SegmentFile::open(
        path, [&](std::int64_t, std::string_view payload) { payloads.emplace_back(payload); });
    return payloads;
}

std::string bytes_of(const std::filesystem::path& path) {
    std::ifstream stream(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(stream), {}};
}

void write_bytes(const std::filesystem::path& path, const std::string& bytes) {
    std::ofstream(path, std::ios::binary) << bytes;
}

class SegmentFileTest : public testing::Test {
protected:
    SegmentFileTest() {
        SegmentFile file = SegmentFile::create(path_);
        for (const auto& payload : all_) ends_.push_back(file.append(payload));
        whole_ = bytes_of(path_);
    }

    TemporaryFolder folder_;
    std::filesystem::path path_ = folder_ / "segment";
    Payloads all_ = {"first", "the second one", std::string(100, '\0')};
    std::vector<std::int64_t> ends_;  // of what is before each record
    std::string whole_;
};

TEST_F(SegmentFileTest, GivesBackWhatWasAppended) { EXPECT_EQ(payloads_in(path_), all_); }

TEST_F(SegmentFileTest, KeepsWholeRecordsAfterPowerLossAtAnyPoint) {
    for (std::size_t length = 8; length < whole_.size(); ++length) {
        write_bytes(path_, whole_.substr(0, length));
        std::size_t num_whole = 0;
        while (num_whole + 1 < ends_.size() &&
               ends_[num_whole + 1] <= static_cast<std::int64_t>(length))
            ++num_whole;
        ASSERT_EQ(payloads_in(path_), Payloads(all_.begin(), all_.begin() + num_whole)) << length;
        ASSERT_EQ(bytes_of(path_).size(), static_cast<std::size_t>(ends_[num_whole])) << length;
    }
}

TEST_F(SegmentFileTest, KeepsWhatIsBeforeAFlippedByte) {
    for (std::size_t at = ends_.back(); at < whole_.size(); ++at) {
        std::string bytes = whole_;
        bytes[at] = static_cast<char>(bytes[at] ^ 0x10);
        write_bytes(path_, bytes);
        ASSERT_EQ(payloads_in(path_), Payloads(all_.begin(), all_.end() - 1)) << at;
    }
}

TEST_F(SegmentFileTest, TakesATailOfZerosForNone) {
    write_bytes(path_, whole_ + std::string(4096, '\0'));
    EXPECT_EQ(payloads_in(path_), all_);
    EXPECT_EQ(bytes_of(path_), whole_);
}

TEST_F(SegmentFileTest, GoesOnAfterATornTail) {
    write_bytes(path_, whole_.substr(0, whole_.size() - 1));
    SegmentFile file = SegmentFile::open(path_, [](std::int64_t, std::string_view) {});
    file.append("after");
    EXPECT_EQ(payloads_in(path_), (Payloads{"first", "the second one", "after"}));
}

TEST_F(SegmentFileTest, IsAsItWasWhenTheDiskIsFull) {
    signal(SIGXFSZ, SIG_IGN);
    SegmentFile file = SegmentFile::open(path_, [](std::int64_t, std::string_view) {});
    rlimit before{};
    getrlimit(RLIMIT_FSIZE, &before);
    const rlimit tight{whole_.size() + 20, before.rlim_max};
    setrlimit(RLIMIT_FSIZE, &tight);
    ErrorCode code = ErrorCode::Gone;
    try {
        file.append(std::string(1000, 'x'));
    } catch (const Error& error) {
        code = error.code();
    }
    setrlimit(RLIMIT_FSIZE, &before);
    EXPECT_EQ(code, ErrorCode::OutOfSpace);
    EXPECT_EQ(bytes_of(path_), whole_);
    file.append("room again");
    EXPECT_EQ(payloads_in(path_).back(), "room again");
}

TEST(SegmentFileOfOthersTest, IsRefused) {
    const TemporaryFolder folder;
    write_bytes(folder / "other", "no segment at all");
    EXPECT_THROW(payloads_in(folder / "other"), Error);
}

}  // namespace
}  // namespace divemesh::sensor
