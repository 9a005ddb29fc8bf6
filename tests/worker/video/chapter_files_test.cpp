#include "worker/video/chapter_files.hpp"

#include <gtest/gtest.h>

#include <fstream>

#include "tests/temporary_folder.hpp"

namespace divemesh::video {
namespace {

namespace fs = std::filesystem;

class ChapterFilesTest : public testing::Test {
protected:
    void lay(const std::vector<std::string>& names) {
        for (const std::string& name : names) std::ofstream(folder_ / name) << "x";
    }
    // Returns the names of the chapters that are joined with a file.
    std::vector<std::string> joined(const std::string& name) const {
        std::vector<std::string> names;
        for (const fs::path& file : find_chapters(folder_ / name).files) {
            EXPECT_EQ(file.parent_path(), folder_.path());
            names.push_back(file.filename().string());
        }
        return names;
    }

    TemporaryFolder folder_;
};

using Names = std::vector<std::string>;

TEST_F(ChapterFilesTest, EveryNamingOfTheCameraIsFollowedInOrder) {
    lay({"GX010123.MP4", "GX030123.MP4", "GX020123.MP4", "GX010124.MP4", "GH010123.MP4"});
    lay({"GH020123.MP4", "GX020123.LRV", "GX020123.THM", "GOPR0123.MP4", "GP010123.MP4"});
    lay({"GP020123.MP4", "GL020123.MP4", "GX0A0123.MP4", "GX000123.MP4", "notes.txt"});
    EXPECT_EQ(joined("GX010123.MP4"), Names({"GX010123.MP4", "GX020123.MP4", "GX030123.MP4"}));
    EXPECT_EQ(joined("GH010123.MP4"), Names({"GH010123.MP4", "GH020123.MP4"}));
    EXPECT_EQ(joined("GOPR0123.MP4"), Names({"GOPR0123.MP4", "GP010123.MP4", "GP020123.MP4"}));
    EXPECT_EQ(joined("GX010124.MP4"), Names({"GX010124.MP4"}));
    EXPECT_EQ(joined("GX000123.MP4"), Names({"GX000123.MP4"}));
    EXPECT_EQ(joined("notes.txt"), Names({"notes.txt"}));
}

TEST_F(ChapterFilesTest, NamesInSmallLettersAndManyChaptersAreFollowed) {
    Names names;
    for (int i = 1; i < 100; ++i)
        names.push_back((i < 10 ? "gx0" : "gx") + std::to_string(i) + "0001.mp4");
    lay(names);
    EXPECT_EQ(joined(names.front()), names);
    fs::remove(folder_ / "gx120001.mp4");
    fs::create_directory(folder_ / "gx120001.mp4");  // a folder is no chapter
    const ChapterFiles chapters = find_chapters(folder_ / names.front());
    EXPECT_EQ(chapters.files.size(), 11U);
    EXPECT_EQ(chapters.missing, "GX120001.MP4");
    EXPECT_EQ(chapters.after_gap.size(), 87U);
}

TEST_F(ChapterFilesTest, AFileAfterOthersIsAloneAndTheFirstOfThoseLeftIsNot) {
    lay({"GX020123.MP4", "GX030123.MP4"});
    EXPECT_EQ(joined("GX020123.MP4"), Names({"GX020123.MP4", "GX030123.MP4"}));
    EXPECT_EQ(joined("GX030123.MP4"), Names({"GX030123.MP4"}));
    EXPECT_EQ(find_chapters(folder_ / "GX030123.MP4").earlier, Names({"GX020123.MP4"}));
}

TEST_F(ChapterFilesTest, ChaptersOfOneRecordingAreKnownByFolderAndName) {
    EXPECT_TRUE(are_chapters_of_one("d/GX010123.MP4", "./d/GX020123.MP4"));
    EXPECT_FALSE(are_chapters_of_one("d/GX010123.MP4", "e/GX020123.MP4"));
    EXPECT_FALSE(are_chapters_of_one("GX010123.MP4", "GX010123.MP4"));
    EXPECT_FALSE(are_chapters_of_one("GX010123.MP4", "GX020124.MP4"));
    EXPECT_FALSE(are_chapters_of_one("left.mp4", "right.mp4"));
}

}  // namespace
}  // namespace divemesh::video
