#include "schemas/verdict.hpp"

#include <gtest/gtest.h>

#include "schemas/error.hpp"

namespace divemesh {
namespace {

Finding finding(Severity severity, const std::string& code) { return {severity, code, "", "", ""}; }

TEST(VerdictTest, FindingsForInformationRestrictNothing) {
    EXPECT_EQ(verdict_on({}), Verdict::Good);
    EXPECT_EQ(verdict_on({finding(Severity::Info, "tracking_lost")}), Verdict::Good);
}

TEST(VerdictTest, AWarningRestrictsWhatItsRowSays) {
    const std::vector<Finding> findings = {finding(Severity::Warning, "tracking_lost"),
                                           finding(Severity::Warning, "scale_untested"),
                                           finding(Severity::Warning, "dive_in_segments"),
                                           finding(Severity::Warning, "vertical_unknown"),
                                           finding(Severity::Warning, "surface_incomplete")};
    EXPECT_EQ(verdict_on(findings), Verdict::UsableWithRestrictions);
    EXPECT_EQ(restrictions_of(findings),
              (std::vector<std::string_view>{"path", "scale", "surface"}));
}

TEST(VerdictTest, PositionsThatCouldNotPlaceTheResultRestrictItsPlace) {
    for (const char* const code :
         {"positions_left_out", "positions_untested", "positions_not_joined"})
        EXPECT_EQ(restrictions_of({finding(Severity::Warning, code)}),
                  (std::vector<std::string_view>{"place"}))
            << code;
}

TEST(VerdictTest, AWarningOnTheRecordingAloneRestrictsNothing) {
    EXPECT_EQ(verdict_on({finding(Severity::Warning, "cam0_gap"),
                          finding(Severity::Warning, "imu_timestamp_repeated"),
                          finding(Severity::Warning, "ground_truth_unusable")}),
              Verdict::Good);
}

TEST(VerdictTest, AWarningThatNoRowKnowsRestrictsTheAccuracy) {
    EXPECT_EQ(restriction_of(finding(Severity::Warning, "from_a_later_version")), "accuracy");
}

TEST(VerdictTest, AnErrorLeavesNothingToUse) {
    const std::vector<Finding> findings = {finding(Severity::Warning, "tracking_lost"),
                                           finding(Severity::Error, "no_surface")};
    EXPECT_EQ(verdict_on(findings), Verdict::NotUsable);
    EXPECT_EQ(restrictions_of(findings), (std::vector<std::string_view>{"all"}));
    EXPECT_EQ(first_error(findings)->code, "no_surface");
}

TEST(VerdictTest, WordsAndValuesAgree) {
    for (const Verdict verdict :
         {Verdict::Good, Verdict::UsableWithRestrictions, Verdict::NotUsable})
        EXPECT_EQ(verdict_from_string(to_string(verdict)), verdict);
    EXPECT_THROW(verdict_from_string("fine"), Error);
}

}  // namespace
}  // namespace divemesh
