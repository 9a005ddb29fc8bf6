#include "api/target.hpp"

#include <gtest/gtest.h>

#include "schemas/error.hpp"

namespace divemesh::api {
namespace {

TEST(TargetTest, SplitsPathAndQueryAndUnescapesTheQueryAlone) {
    const auto target = parse_target("/api/v1/jobs/a%2Fb?state=ready&site=Reef%20%26%20wreck&flag");
    EXPECT_EQ(target.path, "/api/v1/jobs/a%2Fb");
    EXPECT_EQ(target.query.at("state"), "ready");
    EXPECT_EQ(target.query.at("site"), "Reef & wreck");
    EXPECT_EQ(target.query.at("flag"), "");
}

TEST(TargetTest, RefusesBrokenEscapesRepeatedNamesAndForeignForms) {
    for (const char* target : {"/a?x=%",
                               "/a?x=%4",
                               "/a?x=%zz",
                               "/a?x=%00",
                               "/a?x=1&x=2",
                               "ftp://a/b",
                               "http:///a",
                               "http://me@a/",
                               "a/b",
                               "*",
                               ""})
        EXPECT_THROW(parse_target(target), Error) << target;
}

TEST(TargetTest, SplitsTheAbsoluteForm) {
    const auto target = parse_target("HTTP://dives.example:8080/api/v1/jobs?state=ready");
    EXPECT_EQ(target.host, "dives.example:8080");
    EXPECT_EQ(target.path, "/api/v1/jobs");
    EXPECT_EQ(target.query.at("state"), "ready");
    EXPECT_EQ(parse_target("https://[::1]?a=b").path, "/");
    EXPECT_EQ(parse_target("/http://a").host, "");
}

TEST(TargetTest, UnescapesOnceOnly) {
    EXPECT_EQ(percent_decode("%252e"), "%2e");
    EXPECT_EQ(percent_decode("%2e%2E"), "..");
    EXPECT_EQ(percent_decode("%00"), std::nullopt);
}

TEST(TargetTest, CountsAreWholeNumbersThatFit) {
    EXPECT_EQ(parse_count("0"), 0);
    EXPECT_EQ(parse_count("9223372036854775807"), 9223372036854775807);
    for (const char* text : {"", "-1", "-0", "+1", " 1", "1 ", "1.0", "0x1", "9223372036854775808"})
        EXPECT_EQ(parse_count(text), std::nullopt) << text;
}

}  // namespace
}  // namespace divemesh::api
