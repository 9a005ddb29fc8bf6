#include "api/etag.hpp"

#include <gtest/gtest.h>

#include "schemas/error.hpp"

namespace divemesh::api {
namespace {

ErrorCode refusal_of(const std::string& if_match) {
    Request request;
    if (!if_match.empty()) request.headers.emplace("if-match", if_match);
    try {
        require_match(request, "body");
    } catch (const Error& error) {
        return error.code();
    }
    return ErrorCode::Cancelled;  // the call was not refused
}

TEST(EtagTest, DiffersWithTheBodyAndIsQuoted) {
    EXPECT_EQ(etag_of("body"), etag_of("body"));
    EXPECT_NE(etag_of("body"), etag_of("Body"));
    EXPECT_TRUE(etag_of("").starts_with('"'));
}

TEST(EtagTest, ReadersCompareWeaklyWritersStrongly) {
    const std::string etag = etag_of("body");
    EXPECT_TRUE(matches_etag("W/" + etag, etag));
    EXPECT_TRUE(matches_etag("\"x\" , " + etag, etag));
    EXPECT_TRUE(matches_etag("*", etag));
    EXPECT_FALSE(matches_etag("", etag));
    EXPECT_EQ(refusal_of(etag), ErrorCode::Cancelled);
    EXPECT_EQ(refusal_of("\"x\", " + etag), ErrorCode::Cancelled);
    EXPECT_EQ(refusal_of("*"), ErrorCode::Cancelled);
    EXPECT_EQ(refusal_of("W/" + etag), ErrorCode::PreconditionFailed);
    EXPECT_EQ(refusal_of("\"x\""), ErrorCode::PreconditionFailed);
    EXPECT_EQ(refusal_of(""), ErrorCode::PreconditionRequired);
}

TEST(EtagTest, WhatTheClientHasIsNotSentAgain) {
    Request request;
    request.headers.emplace("if-none-match", etag_of("body"));
    Response response;
    response.body = "body";
    response.set("Content-Type", "application/json");
    add_etag(request, response);
    EXPECT_EQ(response.status, http::status::not_modified);
    EXPECT_EQ(std::get<std::string>(response.body), "");
    EXPECT_EQ(response.headers.front().first, "ETag");
}

}  // namespace
}  // namespace divemesh::api
