#include "cli/report_text.hpp"

#include <gtest/gtest.h>

namespace divemesh::cli {
namespace {

using nlohmann::json;

json finding(const std::string& severity, const std::string& code) {
    return {{"severity", severity},
            {"code", code},
            {"where", ""},
            {"message", "message of " + code},
            {"remedy", ""}};
}

json report() {
    return {{"reconstruction",
             {{"verdict", "usable_with_restrictions"},
              {"restrictions", {"path", "scale"}},
              {"findings", {finding("warning", "tracking_lost")}}}},
            {"requirements",
             {{{"text", "coverage>=1"}, {"met", false}, {"reason", "it is 0.5"}},
              {{"text", "ate_rmse_m<=1"}, {"met", true}, {"reason", ""}}}},
            {"regressions", json::array()},
            {"figures", json::array()},
            {"findings", {finding("warning", "surface_not_measured")}}};
}

TEST(ReportTextTest, TheVerdictStandsBeforeTheRequirements) {
    EXPECT_EQ(report_summary(report()),
              "         verdict on the reconstruction  usable with restrictions: path, scale\n"
              "NOT MET  coverage>=1                    it is 0.5\n"
              "met      ate_rmse_m<=1\n");
}

TEST(ReportTextTest, AResultThatIsNotUsableSaysSo) {
    json document = report();
    document["reconstruction"]["verdict"] = "not_usable";
    document["reconstruction"]["restrictions"] = {"all"};
    EXPECT_NE(report_summary(document).find("verdict on the reconstruction  not usable\n"),
              std::string::npos);
}

TEST(ReportTextTest, FindingsOnTheReconstructionComeFirst) {
    const std::string text = report_findings(report());
    const auto lost = text.find("message of tracking_lost (tracking_lost)");
    ASSERT_NE(lost, std::string::npos);
    EXPECT_GT(text.find("surface_not_measured"), lost);
}

TEST(ReportTextTest, AReportOfAnOlderVersionHasNoVerdict) {
    json document = report();
    document["reconstruction"] = {{"version", "0.1.0"}};
    EXPECT_EQ(report_summary(document).find("verdict"), std::string::npos);
    EXPECT_EQ(report_findings(document).find("tracking_lost"), std::string::npos);
}

}  // namespace
}  // namespace divemesh::cli
