#include <gtest/gtest.h>

#include <fstream>
#include <gmock/gmock.h>
#include <opencv2/core.hpp>

#include "tests/temporary_folder.hpp"
#include "tests/worker/dive/finding_matcher.hpp"
#include "tests/worker/dive/test_archive.hpp"
#include "tests/worker/dive/tiny_dive.hpp"
#include "worker/dive/dive.hpp"
#include "worker/dive/intake.hpp"

namespace divemesh::dive {
namespace {

struct Form {
    const char* file;
    Container container;
};

void PrintTo(const Form& form, std::ostream* out) { *out << form.file; }

class ContainersTest : public testing::TestWithParam<Form> {
protected:
    std::filesystem::path packed(const std::string& prefix) const {
        const auto file = folder_ / GetParam().file;
        TestArchive(file, GetParam().container).add_folder(tiny_.folder(), prefix);
        return file;
    }

    const TemporaryFolder folder_;
    const TemporaryFolder scratch_;
    const TinyDive tiny_{folder_ / "dive"};
};

TEST_P(ContainersTest, GivesTheFramesAndTheIdentityOfTheFolder) {
    const auto from_folder = Dive::open(tiny_.folder(), scratch_.path());
    const auto from_archive = Dive::open(packed("MyDive/"), scratch_.path());

    EXPECT_EQ(from_archive->content_sha256(), from_folder->content_sha256());
    EXPECT_EQ(from_archive->info().name, "Tiny");
    EXPECT_EQ(from_archive->imu().size(), from_folder->imu().size());
    for (int i = 0; i < TinyDive::kNumFrames; ++i) {
        const auto a = from_folder->next_frame();
        const auto b = from_archive->next_frame();
        ASSERT_TRUE(a && b);
        EXPECT_EQ(a->timestamp_ns, b->timestamp_ns);
        EXPECT_EQ(cv::norm(a->left, b->left), 0.0);
        EXPECT_EQ(cv::norm(a->right, b->right), 0.0);
    }
    EXPECT_FALSE(from_archive->next_frame().has_value());
}

TEST_P(ContainersTest, LeavesNothingWithANameInTheScratchFolder) {
    const auto dive = Dive::open(packed(""), scratch_.path());

    EXPECT_TRUE(std::filesystem::is_empty(scratch_.path()));
}

TEST_P(ContainersTest, CutShortIsRefusedOrToldAndNeverCrashes) {
    const auto file = packed("");
    std::filesystem::resize_file(file, std::filesystem::file_size(file) / 2);

    const auto report = examine_dive(file, scratch_.path(), base::ignore_progress);

    EXPECT_TRUE(has_error(report.findings));
}

INSTANTIATE_TEST_SUITE_P(Archives,
                         ContainersTest,
                         testing::Values(Form{"dive.zip", Container::Zip},
                                         Form{"dive.tar", Container::Tar},
                                         Form{"dive.tar.gz", Container::TarGz},
                                         Form{"dive.tar.zst", Container::TarZst}),
                         [](const auto& form) {
                             return "form" + std::to_string(static_cast<int>(form.param.container));
                         });

TEST(FolderTest, ASecondDiveIsToldAndTheFirstIsUsed) {
    const TemporaryFolder folder;
    const TinyDive monday(folder / "both/monday");
    const TinyDive tuesday(folder / "both/tuesday");
    tuesday.remove("mav0/imu0");
    tuesday.remove("mav0/cam0/data.csv");

    const auto report =
        examine_dive(folder / "both", folder / "scratch", base::ignore_progress).findings;

    EXPECT_THAT(report, HasFinding(Severity::Warning, "further_dive", "tuesday/"));
    EXPECT_FALSE(has_error(report));
}

TEST(FolderTest, Mav0ItselfMayBeTheRoot) {
    const TemporaryFolder folder;
    const TinyDive tiny(folder / "dive");
    tiny.remove("dive.json");

    const auto whole = Dive::open(tiny.folder(), folder / "scratch");
    const auto mav0 = Dive::open(tiny.folder() / "mav0", folder / "scratch");

    EXPECT_EQ(mav0->num_frames(), TinyDive::kNumFrames);
    EXPECT_EQ(mav0->content_sha256(), whole->content_sha256());
}

// The digests are what `sha256sum mav0/a | sha256sum` and `sha256sum .DS_Store mav0/a | sha256sum`
// print.
TEST(FolderTest, IsKnownByItsHashesWithAndWithoutWhatDesktopsLeave) {
    const TemporaryFolder folder;
    std::filesystem::create_directories(folder / "dive/mav0");
    std::ofstream(folder / "dive/mav0/a") << "abc";
    std::ofstream(folder / "dive/.DS_Store") << "seen";

    const ContentHash hash = Dive::open(folder / "dive", folder / "scratch")->content_hash();

    EXPECT_EQ(hash.sha256, "2bdb05d3968c2c2844cf36dfaadc22cbd6d1d31165dd7fc86e937ffee61dd58f");
    EXPECT_EQ(hash.with_desktop_files,
              "10a6d48fa887e10bf52b76bb556a70010548b7d4300d106fd097082f6789494b");
}

TEST(FolderTest, ALinkOutOfTheDiveIsNotFollowed) {
    const TemporaryFolder folder;
    const TinyDive tiny(folder / "dive");
    const std::string image = "mav0/cam0/data/" + TinyDive::image_name(1);
    std::filesystem::rename(tiny.folder() / image, folder / "outside.png");
    std::filesystem::create_symlink(folder / "outside.png", tiny.folder() / image);

    const auto report = examine_dive(tiny.folder(), folder / "scratch", base::ignore_progress);

    EXPECT_THAT(report.findings, HasFinding(Severity::Warning, "file_left_out", image));
    EXPECT_THAT(report.findings, HasFinding(Severity::Warning, "image_missing", image));
}

TEST(FolderTest, NothingThereIsNotFound) {
    const TemporaryFolder folder;

    try {
        Dive::open(folder / "absent", folder / "scratch");
        FAIL() << "opened";
    } catch (const Error& error) {
        EXPECT_EQ(error.code(), ErrorCode::NotFound);
    }
}

TEST(FolderTest, CancellingStopsTheExamination) {
    const TemporaryFolder folder;
    const TinyDive tiny(folder / "dive");
    const auto cancel = [](const Progress&) { throw Error(ErrorCode::Cancelled, "stop"); };

    EXPECT_THROW(examine_dive(tiny.folder(), folder / "scratch", cancel), Error);
}

TEST(FolderTest, ASecondPassGivesTheSameFramesAndTellsNothingTwice) {
    const TemporaryFolder folder;
    const TinyDive tiny(folder / "dive");
    tiny.write("mav0/cam1/data/" + TinyDive::image_name(2), "broken");
    const auto dive = Dive::open(tiny.folder(), folder / "scratch");
    std::vector<int> first;
    std::vector<int> second;

    while (const auto frame = dive->next_frame()) first.push_back(frame->index);
    const auto num_findings = dive->findings().size();
    dive->rewind();
    while (const auto frame = dive->next_frame()) second.push_back(frame->index);

    EXPECT_THAT(first, testing::ElementsAre(0, 1, 3, 4));
    EXPECT_EQ(first, second);
    EXPECT_EQ(dive->findings().size(), num_findings);
    EXPECT_EQ(dive->num_skipped_frames(), 1);
}

}  // namespace
}  // namespace divemesh::dive
