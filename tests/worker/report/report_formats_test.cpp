#include "worker/report/report_formats.hpp"

#include <gtest/gtest.h>

namespace divemesh::report {
namespace {

using nlohmann::json;

json finding(const std::string& code, const std::string& message) {
    return {{"severity", "warning"},
            {"code", code},
            {"where", ""},
            {"message", message},
            {"remedy", ""}};
}

json report() {
    return {{"dive", {{"name", "wreck <\"&'\x01> 2"}, {"content_sha256", "abc"}}},
            {"figures", json::array()},
            {"reconstruction",
             {{"verdict", "usable_with_restrictions"},
              {"restrictions", {"path", "scale"}},
              {"findings", {finding("tracking_lost", "vision <lost> the \"ground\"")}}}},
            {"findings", {finding("surface_not_measured", "no truth")}},
            {"requirements",
             {{{"text", "drift_percent<=0.5"},
               {"figure", "trajectory.final.drift_percent"},
               {"value", 0.4},
               {"met", true},
               {"reason", ""}},
              {{"text", "coverage>=1"},
               {"figure", "frames.coverage"},
               {"value", nullptr},
               {"met", false},
               {"reason", "not available <here>"}}}}};
}

json metric(const std::string& name, const json& value) {
    return {{"figure", name}, {"value", value}, {"unit", "m"}, {"method", ""}, {"alignment", ""}};
}

std::string row_of(const std::string& name, const json& value) {
    json document = report();
    document["figures"] = {metric(name, value)};
    const std::string csv = report_csv(document);
    const auto head = std::string("figure,value,unit,method,alignment\r\n");
    EXPECT_TRUE(csv.starts_with(head));
    return csv.substr(head.size());
}

TEST(ReportCsv, NumbersReadBackTheSame) {
    EXPECT_EQ(row_of("mesh.area_m2", 0.1), "mesh.area_m2,0.1,m,,\r\n");
    EXPECT_EQ(row_of("mesh.area_m2", -1.0 / 3.0), "mesh.area_m2,-0.3333333333333333,m,,\r\n");
    EXPECT_EQ(row_of("mesh.area_m2", nullptr), "mesh.area_m2,,m,,\r\n");
}

TEST(ReportCsv, ATextThatASpreadsheetWouldRunIsDefused) {
    for (const char* name : {"=cmd|' /C calc'!A0", "+1", "-2+3", "@SUM(A1)", "\tx", "\rx"}) {
        const std::string row = row_of(name, 1);
        EXPECT_TRUE(row.starts_with("'") || row.starts_with("\"'")) << row;
    }
}

TEST(ReportCsv, CommasQuotesAndLineEndsStayInTheirCell) {
    EXPECT_EQ(row_of("a,\"b\"\nc", 1), "\"a,\"\"b\"\"\nc\",1,m,,\r\n");
}

TEST(ReportJunit, EachRequirementIsACaseAndWhatIsNotMetFails) {
    const std::string xml = report_junit(report());
    EXPECT_NE(xml.find("tests=\"2\" failures=\"1\""), std::string::npos);
    EXPECT_NE(xml.find("<testcase classname=\"trajectory.final.drift_percent\" "
                       "name=\"drift_percent&lt;=0.5\" time=\"0\"/>"),
              std::string::npos);
    EXPECT_NE(xml.find("<failure type=\"requirement\" message=\"not available &lt;here&gt;\">"),
              std::string::npos);
}

TEST(ReportJunit, StatesTheVerdictAndTheFindings) {
    const std::string xml = report_junit(report());
    EXPECT_NE(xml.find("<property name=\"verdict\" value=\"usable_with_restrictions\"/>"),
              std::string::npos);
    EXPECT_NE(xml.find("<property name=\"restrictions\" value=\"path, scale\"/>"),
              std::string::npos);
    const auto lost = xml.find("warning tracking_lost: vision &lt;lost&gt; the");
    ASSERT_NE(lost, std::string::npos);
    EXPECT_GT(xml.find("surface_not_measured"), lost);
}

TEST(ReportJunit, AReconstructionOfAnOlderVersionHasNoVerdict) {
    json document = report();
    document["reconstruction"] = {{"findings", json::array()}};
    document["findings"] = json::array();
    const std::string xml = report_junit(document);
    EXPECT_EQ(xml.find("<propert"), std::string::npos);
    EXPECT_EQ(xml.find("<system-out"), std::string::npos);
}

// Parses like an XML parser: every tag is closed in order, and there is no bare &, < or control
// character.
TEST(ReportJunit, IsWellFormedWhateverTheNames) {
    const std::string xml = report_junit(report());
    std::vector<std::string> open;
    std::size_t place = xml.find("?>") + 2;
    while ((place = xml.find('<', place)) != std::string::npos) {
        const auto end = xml.find('>', place);
        ASSERT_NE(end, std::string::npos);
        const std::string tag = xml.substr(place + 1, end - place - 1);
        EXPECT_EQ(tag.find('<'), std::string::npos) << tag;
        if (tag[0] == '/') {
            ASSERT_FALSE(open.empty());
            EXPECT_EQ(tag.substr(1), open.back());
            open.pop_back();
        } else if (tag.back() != '/') {
            open.push_back(tag.substr(0, tag.find(' ')));
        }
        place = end;
    }
    EXPECT_TRUE(open.empty());
    for (const char c : xml) EXPECT_TRUE(c == '\n' || static_cast<unsigned char>(c) >= 0x20);
}

}  // namespace
}  // namespace divemesh::report
