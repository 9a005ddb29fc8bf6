#include "api/client/dive_tar.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cstdio>
#include <fstream>
#include <memory>

#include "api/client/tar_header.hpp"
#include "schemas/content_hash.hpp"
#include "schemas/error.hpp"
#include "tests/temporary_folder.hpp"

namespace divemesh::api::client {
namespace {

namespace fs = std::filesystem;

void write_file(const fs::path& path, const std::string& text) {
    fs::create_directories(path.parent_path());
    std::ofstream(path, std::ios::binary) << text;
}

std::string read_from(ByteSource& source, std::int64_t offset, std::size_t chunk) {
    std::string bytes;
    std::vector<char> buffer(chunk);
    while (const std::size_t count = source.read_at(offset, buffer)) {
        bytes.append(buffer.data(), count);
        offset += static_cast<std::int64_t>(count);
    }
    return bytes;
}

std::string output_of(const std::string& command) {
    const std::unique_ptr<FILE, int (*)(FILE*)> pipe(::popen(command.c_str(), "r"), &::pclose);
    std::string text;
    std::array<char, 4096> buffer{};
    while (const std::size_t count = std::fread(buffer.data(), 1, buffer.size(), pipe.get()))
        text.append(buffer.data(), count);
    return text;
}

class DiveTarTest : public testing::Test {
protected:
    void SetUp() override {
        write_file(dive / "mav0/cam1/data.csv", "right\n");
        write_file(dive / "mav0/cam0/data.csv", "left\n");
        write_file(dive / "mav0/cam0/data/" / fs::path(std::string(180, 'n') + ".png"), "long");
        write_file(dive / "mav0/cam0/h\xC3\xBCtte.txt", "umlaut");
        write_file(dive / "mav0/empty", "");
        write_file(dive / "mav0/block", std::string(512, 'b'));
        write_file(dive / "dive.json", "{}");
    }

    TemporaryFolder folder;
    fs::path dive = folder / "dive";
};

TEST_F(DiveTarTest, IsWhatTarUnpacksToTheSameFiles) {
    DiveTar tar(dive, Links::LeaveOut);
    write_file(folder / "dive.tar", read_from(tar, 0, 1000));
    EXPECT_EQ(fs::file_size(folder / "dive.tar"), tar.size_bytes());
    fs::create_directory(folder / "unpacked");
    const auto unpacked = (folder / "unpacked").string();
    EXPECT_EQ(output_of("tar -xf '" + (folder / "dive.tar").string() + "' -C '" + unpacked +
                        "' 2>&1 && diff -r '" + dive.string() + "' '" + unpacked + "' 2>&1"),
              "");
}

TEST_F(DiveTarTest, ListsItsNamesSortedWithFixedTimesAndOwners) {
    DiveTar tar(dive, Links::LeaveOut);
    write_file(folder / "dive.tar", read_from(tar, 0, 4096));
    const auto listing = output_of("TZ=UTC tar --numeric-owner -tvf '" +
                                   (folder / "dive.tar").string() + "' | head -2");
    EXPECT_EQ(listing,
              "-rw-r--r-- 0/0               2 1970-01-01 00:00 dive.json\n"
              "-rw-r--r-- 0/0             512 1970-01-01 00:00 mav0/block\n");
}

TEST_F(DiveTarTest, CanBeReadFromAnyOffset) {
    DiveTar tar(dive, Links::LeaveOut);
    const std::string whole = read_from(tar, 0, 1 << 20);
    for (std::int64_t offset = 0; offset <= tar.size_bytes(); offset += 97)
        ASSERT_EQ(read_from(tar, offset, 333), whole.substr(static_cast<std::size_t>(offset)));
}

TEST_F(DiveTarTest, HashesWhatItSendsAndTheDivesIdentity) {
    DiveTar tar(dive, Links::LeaveOut);
    const DiveHashes hashes = tar.hash([](std::int64_t) {});
    EXPECT_EQ(hashes.archive_sha256, sha256_hex(read_from(tar, 0, 1 << 20)));
    const auto expected = output_of("cd '" + dive.string() +
                                    "' && find . -type f -printf '%P\\n' | LC_ALL=C sort | "
                                    "xargs -d '\\n' sha256sum | sha256sum | cut -c1-64");
    EXPECT_EQ(hashes.content_sha256 + "\n", expected);
}

TEST_F(DiveTarTest, IsTheSameDiveWhenMav0ItselfIsGiven) {
    fs::remove(dive / "dive.json");
    DiveTar parent(dive, Links::LeaveOut);
    DiveTar mav0(dive / "mav0", Links::LeaveOut);
    EXPECT_EQ(mav0.hash([](std::int64_t) {}).archive_sha256,
              parent.hash([](std::int64_t) {}).archive_sha256);
}

TEST_F(DiveTarTest, LeavesOutLinksAndSaysSo) {
    fs::create_symlink("/etc/passwd", dive / "mav0/link");
    const DiveTar tar(dive, Links::LeaveOut);
    EXPECT_EQ(tar.left_out(), std::vector<std::string>{"mav0/link"});
    EXPECT_EQ(tar.num_files(), 7U);
}

// What a Finder or Explorer window leaves behind changes neither what is sent nor the identity.
TEST_F(DiveTarTest, LeavesOutWhatDesktopsLeave) {
    for (const Links links : {Links::LeaveOut, Links::Follow}) {
        const auto bytes = [&] {
            DiveTar tar(dive, links);
            EXPECT_TRUE(tar.left_out().empty());
            return read_from(tar, 0, 1 << 20);
        };
        const std::string before = bytes();
        for (const char* name : {".DS_Store",
                                 "mav0/.DS_Store",
                                 "mav0/cam0/._data.csv",
                                 "mav0/cam0/data/Thumbs.db",
                                 "mav0/cam1/desktop.ini",
                                 "mav0/cam1/Desktop.ini"})
            write_file(dive / name, "seen");
        EXPECT_EQ(bytes(), before);
        write_file(dive / "mav0/_data.csv", "of the dive");
        EXPECT_NE(bytes(), before);
        fs::remove_all(dive);
        SetUp();
    }
}

TEST_F(DiveTarTest, SendsWhatLinksLeadToUnderTheirNames) {
    fs::rename(dive / "mav0/cam1", folder / "right");
    fs::create_symlink("../../right", dive / "mav0/cam1");
    fs::rename(dive / "mav0/block", dive / "block");
    fs::create_symlink("../block", dive / "mav0/block");
    fs::create_directories(folder / "copy");
    output_of("cp -rL '" + dive.string() + "' '" + (folder / "copy").string() + "'");
    DiveTar tar(dive, Links::Follow);
    DiveTar copy(folder / "copy" / dive.filename(), Links::LeaveOut);
    EXPECT_EQ(read_from(tar, 0, 1 << 20), read_from(copy, 0, 1 << 20));
    EXPECT_TRUE(tar.left_out().empty());
}

TEST_F(DiveTarTest, LeavesOutLinksThatLeadNowhereOrBackAndWhatGitKeeps) {
    fs::create_symlink("gone.png", dive / "mav0/gone");
    fs::create_symlink("..", dive / "mav0/back");
    fs::create_symlink("/dev/zero", dive / "mav0/endless");
    write_file(dive / ".git/config", "kept by Git");
    const DiveTar tar(dive, Links::Follow);
    EXPECT_EQ(tar.left_out(), (std::vector<std::string>{"mav0/back", "mav0/endless", "mav0/gone"}));
    EXPECT_EQ(tar.num_files(), 7U);
}

TEST_F(DiveTarTest, RefusesAFolderThatIsNoDive) {
    fs::create_directory(folder / "other");
    EXPECT_THROW(DiveTar(folder / "other", Links::LeaveOut), Error);
    EXPECT_THROW(DiveTar(folder.path(), Links::LeaveOut), Error);  // the parent folder of a dive
}

TEST_F(DiveTarTest, SendsAFolderOfImagesAsItIs) {
    write_file(folder / "stills/left/1.png", "left");
    write_file(folder / "stills/right/1.png", "right");
    DiveTar tar(folder / "stills", Links::LeaveOut, TarOf::Recording);
    write_file(folder / "stills.tar", read_from(tar, 0, 1000));
    EXPECT_EQ(output_of("tar -tf '" + (folder / "stills.tar").string() + "'"),
              "left/1.png\nright/1.png\n");
    const DiveHashes hashes = tar.hash([](std::int64_t) {});
    EXPECT_EQ(hashes.archive_sha256, sha256_hex(read_from(tar, 0, 4096)));
    EXPECT_EQ(hashes.content_sha256, "");  // the server tells it, which makes the dive of it

    fs::create_directory(folder / "nothing");
    EXPECT_THROW(DiveTar(folder / "nothing", Links::LeaveOut, TarOf::Recording), Error);
}

TEST_F(DiveTarTest, NoticesAFileThatChangedMeanwhile) {
    DiveTar tar(dive, Links::LeaveOut);
    write_file(dive / "mav0/block", std::string(513, 'b'));
    EXPECT_THROW(read_from(tar, 0, 4096), Error);
}

TEST(TarHeaderTest, KeepsSizesBeyondUstarsEightGibibytes) {
    const std::string header = tar_header("mav0/huge", std::int64_t{9} << 30);
    EXPECT_NE(header.find("19 size=9663676416\n"), std::string::npos);
    EXPECT_EQ(header.size(), 3 * 512U);
}

}  // namespace
}  // namespace divemesh::api::client
