#include "worker/report/html_template.hpp"

#include <gtest/gtest.h>

#include <stdexcept>

#include "worker/report/html_parts.hpp"

namespace divemesh::report {
namespace {

using nlohmann::json;

constexpr char kHostile[] = R"(<script>alert('1')</script>" onload="x" & {{other}})";

// Returns what a browser reads as text.
std::string unescaped(std::string text) {
    const std::pair<const char*, const char*> kEntities[] = {
        {"&lt;", "<"}, {"&gt;", ">"}, {"&quot;", "\""}, {"&apos;", "'"}, {"&amp;", "&"}};
    for (const auto& [entity, character] : kEntities)
        for (std::size_t at = 0; (at = text.find(entity, at)) != std::string::npos; ++at)
            text.replace(at, std::string(entity).size(), character);
    return text;
}

TEST(HtmlTemplate, HostileTextStaysText) {
    const std::string html = fill_template("{{text}}", {{"text", kHostile}});
    EXPECT_EQ(html.find_first_of("<>\"'"), std::string::npos) << html;
    EXPECT_EQ(unescaped(html), kHostile);
}

TEST(HtmlTemplate, HostileTextStaysTextInEveryPart) {
    const json values = {
        {"title", kHostile},
        {"table", rows_values({{kHostile, kHostile}})},
        {"cells", grid_values({{kHostile}, {kHostile}})},
        {"findings", findings_values({{{"severity", kHostile}, {"message", kHostile}}})}};
    const std::string html = fill_template(
        "{{>page_head}}{{#table}}{{>rows}}{{/table}}{{#cells}}{{>grid}}{{/cells}}{{>findings}}",
        values);
    EXPECT_EQ(html.find("<script"), std::string::npos);
    EXPECT_EQ(html.find("onload=\""), std::string::npos);
    std::size_t num_shown = 0;
    for (std::size_t at = 0; (at = html.find("&lt;script&gt;", at)) != std::string::npos; ++at)
        ++num_shown;
    EXPECT_EQ(num_shown, 8U);
}

TEST(HtmlTemplate, WhatIsHtmlAlreadyIsNotEscapedAgain) {
    EXPECT_EQ(fill_template("{{{svg}}}", {{"svg", "<svg>&amp;</svg>"}}), "<svg>&amp;</svg>");
}

TEST(HtmlTemplate, ASectionIsRepeatedForEachItem) {
    const json values = {{"rows", {{{"name", "a"}}, {{"name", "b"}}}}};
    EXPECT_EQ(fill_template("{{#rows}}[{{name}}]{{/rows}}", values), "[a][b]");
}

TEST(HtmlTemplate, WhatIsNotThereLeavesItsSectionOut) {
    const std::string text = "{{#part}}there{{/part}}{{^part}}none{{/part}}";
    EXPECT_EQ(fill_template(text, {{"part", nullptr}}), "none");
    EXPECT_EQ(fill_template(text, {{"part", false}}), "none");
    EXPECT_EQ(fill_template(text, {{"part", json::array()}}), "none");
    EXPECT_EQ(fill_template(text, {{"part", true}}), "there");
    EXPECT_EQ(fill_template(text, {{"part", {{"a", 1}}}}), "there");
}

TEST(HtmlTemplate, AMissingValueIsAnError) {
    const json values = {{"there", "x"}};
    EXPECT_THROW(fill_template("{{missing}}", values), std::logic_error);
    EXPECT_THROW(fill_template("{{{missing}}}", values), std::logic_error);
    EXPECT_THROW(fill_template("{{#missing}}x{{/missing}}", values), std::logic_error);
    EXPECT_THROW(fill_template("{{^missing}}x{{/missing}}", values), std::logic_error);
    EXPECT_THROW(fill_template("{{>missing}}", values), std::logic_error);
}

TEST(HtmlTemplate, AMalformedTemplateIsAnError) {
    const json values = {{"a", "x"}};
    EXPECT_THROW(fill_template("{{#a}}x", values), std::logic_error);
    EXPECT_THROW(fill_template("{{a", values), std::logic_error);
}

TEST(HtmlTemplate, TablesWithoutARowAreLeftOut) {
    EXPECT_TRUE(rows_values({}).is_null());
    EXPECT_TRUE(grid_values({{"head"}}).is_null());
    EXPECT_NE(fill_template("{{>findings}}", {{"findings", findings_values(json::array())}})
                  .find("<p>None.</p>"),
              std::string::npos);
}

}  // namespace
}  // namespace divemesh::report
