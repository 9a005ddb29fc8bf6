#include "worker/dive/archive_identity.hpp"

#include <gtest/gtest.h>

#include <cstdlib>
#include <fstream>

#include "api/client/dive_tar.hpp"
#include "schemas/error.hpp"
#include "tests/temporary_folder.hpp"

namespace divemesh::cli {
namespace {

namespace fs = std::filesystem;

void write_file(const fs::path& path, const std::string& text) {
    fs::create_directories(path.parent_path());
    std::ofstream(path, std::ios::binary) << text;
}

TEST(ArchiveIdentityTest, IsTheIdentityThatTheFolderHas) {
    const TemporaryFolder folder;
    write_file(folder / "dive/mav0/cam0/data.csv", "left");
    write_file(folder / "dive/mav0/cam1/h\xC3\xBCtte.png", std::string(100'000, 'x'));
    write_file(folder / "dive/dive.json", "{}");
    const std::string in_folder = "cd '" + folder.path().string() + "' && ";
    ASSERT_EQ(std::system((in_folder + "tar -czf dive.tar.gz dive").c_str()), 0);
    ASSERT_EQ(std::system((in_folder + "cd dive && tar -cf ../dive.tar .").c_str()), 0);

    api::client::DiveTar tar(folder / "dive", Links::LeaveOut);
    const auto expected = tar.hash([](std::int64_t) {}).content_sha256;
    EXPECT_EQ(dive::archive_content_sha256(folder / "dive.tar.gz"), expected);
    EXPECT_EQ(dive::archive_content_sha256(folder / "dive.tar"), expected);
}

TEST(ArchiveIdentityTest, IsTheSameWithWhatDesktopsLeave) {
    const TemporaryFolder folder;
    write_file(folder / "dive/mav0/cam0/data.csv", "left");
    const std::string in_folder = "cd '" + folder.path().string() + "' && ";
    ASSERT_EQ(std::system((in_folder + "tar -cf before.tar dive").c_str()), 0);
    write_file(folder / "dive/.DS_Store", "seen");
    write_file(folder / "dive/mav0/cam0/._data.csv", "seen");
    write_file(folder / "__MACOSX/dive/mav0/cam0/._data.csv", "seen");
    ASSERT_EQ(std::system((in_folder + "tar -cf after.tar dive __MACOSX").c_str()), 0);
    EXPECT_EQ(dive::archive_content_sha256(folder / "after.tar"),
              dive::archive_content_sha256(folder / "before.tar"));
}

TEST(ArchiveIdentityTest, RefusesWhatIsNoArchive) {
    const TemporaryFolder folder;
    write_file(folder / "dive.zip", "this is text");
    EXPECT_THROW(dive::archive_content_sha256(folder / "dive.zip"), Error);
}

}  // namespace
}  // namespace divemesh::cli
