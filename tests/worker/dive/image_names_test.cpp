#include <gtest/gtest.h>

#include <string>

#include "tests/temporary_folder.hpp"
#include "tests/worker/dive/finding_matcher.hpp"
#include "tests/worker/dive/tiny_dive.hpp"
#include "worker/dive/intake.hpp"

namespace divemesh::dive {
namespace {

class ImageNamesTest : public testing::Test {
protected:
    // Lists the images of cam0 with something before each name.
    IntakeReport listed_with(const std::string& before) {
        std::string rows;
        for (int i = 0; i < TinyDive::kNumFrames; ++i)
            rows += std::to_string(TinyDive::kFirst_ns + i * 100'000'000LL) + "," + before +
                    TinyDive::image_name(i) + "\n";
        tiny_.write("mav0/cam0/data.csv", rows);
        return examine_dive(tiny_.folder(), folder_ / "scratch", base::ignore_progress);
    }

    const TemporaryFolder folder_;
    const TinyDive tiny_{folder_ / "dive"};
};

TEST_F(ImageNamesTest, OfAPathTheImageInTheFolderOfTheCameraIsUsed) {
    for (const char* const before : {"data/",
                                     "mav0/cam0/data/",
                                     "../data/",
                                     "/home/diver/recording/",
                                     "C:\\recording\\data\\",
                                     "\\\\boat\\recordings\\"}) {
        const auto told = listed_with(before);

        EXPECT_EQ(told.num_frames, TinyDive::kNumFrames) << before;
        EXPECT_THAT(told.findings,
                    HasFinding(Severity::Warning, "image_names_completed", "5 of 5 rows"))
            << before;
        EXPECT_FALSE(has_error(told.findings)) << before << testing::PrintToString(told.findings);
    }
}

TEST_F(ImageNamesTest, APathToAFileOutsideIsNoImage) {
    tiny_.write("secret.png", tiny_.read("mav0/cam0/data/" + TinyDive::image_name(0)));

    tiny_.write("mav0/cam0/data.csv",
                std::to_string(TinyDive::kFirst_ns) + ",../../../secret.png\n");
    const auto told = examine_dive(tiny_.folder(), folder_ / "scratch", base::ignore_progress);

    EXPECT_THAT(told.findings,
                HasFinding(Severity::Warning, "image_missing", "mav0/cam0/data/secret.png"));
    EXPECT_THAT(told.findings, HasFinding(Severity::Error, "no_frame_decodes", ""));
}

TEST_F(ImageNamesTest, AnImageInAFolderBelowIsTheListedOne) {
    const std::string name = TinyDive::image_name(0);
    tiny_.write("mav0/cam0/data/first/" + name, tiny_.read("mav0/cam0/data/" + name));

    const auto told = listed_with("first/");

    EXPECT_THAT(told.findings,
                HasFinding(Severity::Warning, "image_names_completed", "4 of 5 rows"));
}

}  // namespace
}  // namespace divemesh::dive
