#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <gmock/gmock.h>

#include "tests/temporary_folder.hpp"
#include "tests/worker/dive/finding_matcher.hpp"
#include "tests/worker/dive/test_archive.hpp"
#include "tests/worker/dive/tiny_dive.hpp"
#include "worker/dive/dive_source.hpp"
#include "worker/dive/intake.hpp"

namespace divemesh::dive {
namespace {

namespace fs = std::filesystem;

// Puts a link to each file of a folder into another one, as `cp -rs` does.
void link_files(const fs::path& from, const fs::path& to) {
    for (const auto& entry : fs::recursive_directory_iterator(from)) {
        const fs::path place = to / entry.path().lexically_relative(from);
        if (entry.is_directory()) {
            fs::create_directories(place);
        } else {
            fs::create_directories(place.parent_path());
            fs::create_symlink(entry.path(), place);
        }
    }
}

class LinksTest : public testing::Test {
protected:
    IntakeReport examined(const fs::path& dive, Links links) {
        return examine_dive(dive, folder_ / "scratch", base::ignore_progress, {}, links);
    }
    std::vector<std::string> listed(Links links) {
        std::vector<std::string> names;
        const auto source =
            open_folder(folder_ / "links", DiveLimits{}, base::ignore_progress, log_, links);
        for (const SourceFile& file : source->files()) names.push_back(file.path);
        return names;
    }

    TemporaryFolder folder_;
    TinyDive tiny_{folder_ / "dive"};
    FindingLog log_;
};

TEST_F(LinksTest, ADiveOfLinksIsTheDiveThatTheyLeadTo) {
    link_files(tiny_.folder(), folder_ / "links");

    const auto plain = examined(tiny_.folder(), Links::LeaveOut);
    const auto linked = examined(folder_ / "links", Links::Follow);

    EXPECT_FALSE(has_error(linked.findings));
    EXPECT_EQ(linked.content_sha256, plain.content_sha256);
    EXPECT_EQ(linked.num_frames, TinyDive::kNumFrames);
}

TEST_F(LinksTest, ALinkToAFolderIsFollowedToo) {
    fs::create_directory(folder_ / "links");
    fs::create_symlink("../dive/mav0", folder_ / "links/mav0");
    tiny_.remove("dive.json");

    const auto plain = examined(tiny_.folder(), Links::LeaveOut);
    const auto linked = examined(folder_ / "links", Links::Follow);

    EXPECT_EQ(linked.content_sha256, plain.content_sha256);
}

TEST_F(LinksTest, FilesThatGitAnnexKeepsAreTakenOnceByTheirNames) {
    const fs::path object = folder_ / "links/.git/annex/objects/SHA256E-s4--ab.png";
    fs::create_directories(object.parent_path());
    std::ofstream(object) << "png.";
    fs::create_directories(folder_ / "links/cam0");
    fs::create_symlink("../.git/annex/objects/SHA256E-s4--ab.png", folder_ / "links/cam0/1.png");

    EXPECT_EQ(listed(Links::Follow), std::vector<std::string>{"cam0/1.png"});
}

TEST_F(LinksTest, LinksThatAreLeftOutAreNamedInTheRefusal) {
    link_files(tiny_.folder(), folder_ / "links");

    const auto report = examined(folder_ / "links", Links::LeaveOut);

    EXPECT_THAT(report.findings, HasFinding(Severity::Error, "not_a_dive", ""));
    EXPECT_THAT(report.findings.back().message, testing::HasSubstr("symbolic link"));
    EXPECT_THAT(report.findings.back().remedy, testing::HasSubstr("cp -rL"));
}

TEST_F(LinksTest, ALinkThatLeadsNowhereIsNamedWithItsTarget) {
    const std::string image = "mav0/cam0/data/" + TinyDive::image_name(1);
    tiny_.remove(image);
    fs::create_symlink("../.git/annex/gone.png", tiny_.folder() / image);

    const auto report = examined(tiny_.folder(), Links::Follow);

    EXPECT_FALSE(has_error(report.findings));
    const auto broken =
        std::find_if(report.findings.begin(), report.findings.end(), [](const Finding& finding) {
            return finding.code == "link_broken";
        });
    ASSERT_NE(broken, report.findings.end());
    EXPECT_EQ(broken->where, image);
    EXPECT_THAT(broken->message, testing::HasSubstr("../.git/annex/gone.png"));
}

TEST_F(LinksTest, WithoutItsFilesADiveOfLinksIsRefusedByNamingThem) {
    link_files(tiny_.folder(), folder_ / "links");
    tiny_.remove("mav0");

    const auto report = examined(folder_ / "links", Links::Follow);

    EXPECT_THAT(report.findings, HasFinding(Severity::Error, "not_a_dive", ""));
    EXPECT_THAT(report.findings.back().message, testing::HasSubstr("No such file"));
}

TEST_F(LinksTest, CyclesEnd) {
    fs::create_directories(folder_ / "links/a");
    std::ofstream(folder_ / "links/a/file") << "1";
    fs::create_symlink("..", folder_ / "links/a/up");
    fs::create_symlink(".", folder_ / "links/a/here");
    fs::create_symlink("self", folder_ / "links/self");

    EXPECT_EQ(listed(Links::Follow), std::vector<std::string>{"a/file"});

    EXPECT_THAT(log_.all(), HasFinding(Severity::Warning, "file_left_out", "a/up"));
    EXPECT_THAT(log_.all(), HasFinding(Severity::Warning, "file_left_out", "a/here"));
    EXPECT_THAT(log_.all(), HasFinding(Severity::Warning, "link_broken", "self"));
}

TEST_F(LinksTest, FoldersThatLinksMultiplyEndAtTheLimit) {
    for (int level = 0; level < 15; ++level) {
        const fs::path here = folder_ / "levels" / std::to_string(level);
        fs::create_directories(here);
        for (int i = 0; i < 4; ++i)
            fs::create_symlink("../" + std::to_string(level + 1), here / std::to_string(i));
    }
    fs::create_directories(folder_ / "levels/15");
    fs::create_symlink("levels/0", folder_ / "links");
    DiveLimits few;
    few.max_entries = 20'000;

    EXPECT_THROW(open_folder(folder_ / "links", few, base::ignore_progress, log_, Links::Follow),
                 Error);
}

TEST_F(LinksTest, WhatALinkLeadsToIsReadOnlyIfItIsAFile) {
    fs::create_directories(folder_ / "links");
    fs::create_symlink("/dev/zero", folder_ / "links/endless");

    EXPECT_TRUE(listed(Links::Follow).empty());

    EXPECT_THAT(log_.all(), HasFinding(Severity::Warning, "file_left_out", "endless"));
}

TEST_F(LinksTest, OfAnArchiveTheyAreNeverFollowed) {
    TestArchive(folder_ / "dive.tar", Container::Tar)
        .add_special("mav0/cam0/sensor.yaml", AE_IFLNK, (tiny_.folder() / "dive.json").string());

    const auto report = examined(folder_ / "dive.tar", Links::Follow);

    EXPECT_TRUE(has_error(report.findings));
    EXPECT_THAT(report.findings.back().message, testing::HasSubstr("a link"));
}

}  // namespace
}  // namespace divemesh::dive
