#include "worker/dive/dive_json.hpp"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

namespace divemesh::dive {
namespace {

using nlohmann::json;

std::vector<Finding> told_of(const json& imported_from) {
    FindingLog findings;
    parse_dive_info(json{{"name", "a"}, {"imported_from", imported_from}}.dump(), findings);
    return findings.all();
}

json finding(const json& code, const json& message = "cut") {
    return {{"severity", "warning"},
            {"code", code},
            {"where", "a.bag:7"},
            {"message", message},
            {"remedy", "copy"}};
}

TEST(DiveJsonTest, TellsWhatWasFoundWhenTheDiveWasImported) {
    json info = finding("pressure_converted");
    info["severity"] = "info";
    const auto told = told_of({{"findings", {finding("recording_cut"), info}}});
    ASSERT_EQ(told.size(), 2U);
    EXPECT_EQ(told[0].severity, Severity::Warning);
    EXPECT_EQ(told[0].code, "recording_cut");
    EXPECT_EQ(told[0].where, "a.bag:7");
    EXPECT_EQ(told[0].message, "cut");
    EXPECT_EQ(told[0].remedy, "copy");
    EXPECT_EQ(told[1].severity, Severity::Info);
}

TEST(DiveJsonTest, NotesKeepTheirLinesAndNothingThatMovesACursor) {
    const auto notes_of = [](const json& notes) {
        FindingLog findings;
        return parse_dive_info(json{{"notes", notes}}.dump(), findings).notes;
    };
    EXPECT_EQ(notes_of("calm sea"), "calm sea");
    EXPECT_EQ(notes_of("first\r\nsecond\n\nlast\n"), "first\nsecond\n\nlast\n");
    EXPECT_EQ(notes_of("a\tb\rc"), "a b\nc");
    EXPECT_EQ(notes_of("\x1b[31m red"), "\\x1b[31m red");
    EXPECT_EQ(notes_of(7), "");
    const std::string many = notes_of(std::string(50'000, 'x'));
    EXPECT_GT(many.size(), 9'000U);
    EXPECT_LE(many.size(), 10'000U);
    EXPECT_LE(notes_of(std::string(50'000, '\n')).size(), 10'000U);
}

TEST(DiveJsonTest, AnImportedErrorDoesNotRefuseTheDive) {
    json error = finding("recording_cut");
    error["severity"] = "error";
    EXPECT_EQ(told_of({{"findings", {error}}}).at(0).severity, Severity::Warning);
}

TEST(DiveJsonTest, WhatIsNotAFindingIsLeftOut) {
    for (const json& hostile : {json(7),
                                json("text"),
                                json::array({1, 2}),
                                json{{"findings", 7}},
                                json{{"findings", {{"code", "a"}}}},
                                json{{"findings", {1, "a", nullptr, json::object()}}},
                                json{{"findings", {finding(7)}}},
                                json{{"findings", {finding("")}}},
                                json{{"findings", {finding("<b>")}}},
                                json{{"findings", {finding(std::string(65, 'a'))}}}})
        EXPECT_TRUE(told_of(hostile).empty()) << hostile;
}

TEST(DiveJsonTest, TextsOfFindingsAreShortAndPrintable) {
    const auto told = told_of({{"findings", {finding("a", "\x1b[31m" + std::string(5000, 'x'))}}});
    ASSERT_EQ(told.size(), 1U);
    EXPECT_LT(told[0].message.size(), 1100U);
    EXPECT_TRUE(told[0].message.starts_with("\\x1b[31mx"));
    json many = json::array();
    for (int i = 0; i < 1000; ++i) many.push_back(finding("code_" + std::to_string(i)));
    EXPECT_LE(told_of({{"findings", many}}).size(), 200U);
}

}  // namespace
}  // namespace divemesh::dive
