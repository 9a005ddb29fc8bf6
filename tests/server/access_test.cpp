#include <gtest/gtest.h>

#include "api/routes.hpp"
#include "tests/server/test_server.hpp"

namespace divemesh {
namespace {

// A path of the route's form; the ids exist nowhere.
std::string some_path(std::string_view pattern) {
    std::string path;
    for (std::size_t i = 0; i < pattern.size(); ++i) {
        path += pattern[i] == '{' ? 'x' : pattern[i];
        if (pattern[i] == '{') i = pattern.find('}', i);
    }
    return path;
}

RawResponse ask(const TestServer& server, const api::Route& route, const std::string& token) {
    return server.request(
        std::string(api::http::to_string(route.method)),
        some_path(route.path),
        token,
        {{"Tus-Resumable", "1.0.0"}, {"Content-Type", "application/json"}, {"Upload-Length", "0"}},
        "");
}

TEST(AccessTest, EveryRouteOfTheApiWantsATokenThatItKnows) {
    TestServer server;
    for (const api::Route& route : api::routes()) {
        for (const std::string token : {"", "dm_wrong", "x"}) {
            const auto response = ask(server, route, token);
            if (route.scope.empty())
                EXPECT_LT(response.status, 300) << route.path;
            else
                EXPECT_EQ(response.status, 401) << route.path;
            if (response.status == 401) {
                EXPECT_EQ(response.header("www-authenticate"), "Bearer");
            }
        }
    }
}

TEST(AccessTest, EveryRouteWantsItsScopeAndNoOther) {
    TestServer server;
    for (const std::string scope : {"dives:read", "dives:write", "jobs:write", "admin"}) {
        const std::string token = server.make_token("default", {scope});
        for (const api::Route& route : api::routes()) {
            if (route.scope.empty()) continue;
            const auto response = ask(server, route, token);
            if (scope == route.scope || scope == "admin")
                EXPECT_NE(response.status, 403) << route.path << ' ' << scope;
            else
                EXPECT_EQ(response.status, 403) << route.path << ' ' << scope;
        }
    }
}

TEST(AccessTest, UnknownIdsAreNotFoundOnEveryRoute) {
    TestServer server;
    for (const api::Route& route : api::routes()) {
        if (route.path.find('{') == std::string_view::npos || route.method == api::verb::options)
            continue;
        Headers headers = {{"Tus-Resumable", "1.0.0"}, {"Upload-Offset", "0"}};
        headers.emplace_back("Content-Type",
                             route.method == api::verb::patch ? "application/offset+octet-stream"
                                                              : "application/json");
        const auto response = server.request(std::string(api::http::to_string(route.method)),
                                             some_path(route.path),
                                             server.admin(),
                                             headers,
                                             route.method == api::verb::post ? "{}" : "");
        EXPECT_EQ(response.status, 404) << route.path;
    }
}

TEST(AccessTest, WhatBelongsToAnotherProjectLooksAsIfItWereNotThere) {
    TestServer server;
    const std::string mine = server.make_token("reef", {"dives:read", "dives:write", "jobs:write"});
    const std::string other =
        server.make_token("wreck", {"dives:read", "dives:write", "jobs:write"});
    const std::string job = server.make_job("reef", "metrics.json", "{}");
    const std::string dive = server.request("GET", "/api/v1/jobs/" + job, mine).json()["dive_id"];
    const std::string upload = create_upload(server.port(), mine, 10);
    const Headers tus = {{"Tus-Resumable", "1.0.0"},
                         {"Upload-Offset", "0"},
                         {"Content-Type", "application/offset+octet-stream"}};
    const Headers json = {{"Content-Type", "application/json"}};
    struct Case {
        std::string method;
        std::string path;
        Headers headers;
        std::string body;
    };
    const std::string upload_id = upload.substr(upload.rfind('/') + 1);
    const Case cases[] = {
        {"GET", "/api/v1/dives/" + dive, {}, ""},
        {"GET", "/api/v1/dives/" + dive + "/findings", {}, ""},
        {"GET", "/api/v1/dives/" + dive + "/thumbnail.jpg", {}, ""},
        {"POST", "/api/v1/dives/" + dive + "/jobs", json, "{}"},
        {"POST", "/api/v1/dives", json, R"({"upload_id":")" + upload_id + "\"}"},
        {"GET", "/api/v1/jobs/" + job, {}, ""},
        {"GET", "/api/v1/jobs/" + job + "/log", {}, ""},
        {"GET", "/api/v1/jobs/" + job + "/artifacts", {}, ""},
        {"GET", "/api/v1/jobs/" + job + "/artifacts/metrics.json", {{"Range", "bytes=0-0"}}, ""},
        {"POST", "/api/v1/jobs/" + job + "/cancel", {}, ""},
        {"POST", "/api/v1/jobs/" + job + "/retry", {}, ""},
        {"GET", upload, {}, ""},
        {"HEAD", upload, tus, ""},
        {"PATCH", upload, tus, "hello"},
        {"DELETE", upload, tus, ""},
    };
    for (const Case& c : cases) {
        const auto refused = server.request(c.method, c.path, other, c.headers, c.body);
        EXPECT_EQ(refused.status, 404) << c.method << ' ' << c.path;
        EXPECT_EQ(refused.body.find("reef"), std::string::npos) << refused.body;
    }
    for (const char* list : {"/api/v1/dives", "/api/v1/jobs"}) {
        EXPECT_EQ(server.request("GET", list, other).json()["items"].size(), 0U);
        EXPECT_GT(server.request("GET", list, mine).json()["items"].size(), 0U);
        EXPECT_GT(server.request("GET", list, server.admin()).json()["items"].size(), 0U);
    }
    EXPECT_EQ(upload_offset(server.port(), mine, upload), 0);
}

TEST(AccessTest, ARevokedTokenOpensNothingAnyMore) {
    TestServer server;
    const auto made = server.post_json(
        "/api/v1/tokens", server.admin(), {{"name", "laptop"}, {"scopes", {"dives:read"}}});
    ASSERT_EQ(made.status, 201) << made.body;
    const std::string secret = made.json()["secret"];
    const std::string id = made.json()["id"];
    EXPECT_EQ(server.request("GET", "/api/v1/dives", secret).status, 200);
    EXPECT_EQ(server.request("DELETE", "/api/v1/tokens/" + id, server.admin()).status, 204);
    EXPECT_EQ(server.request("GET", "/api/v1/dives", secret).status, 401);
    const auto list = server.request("GET", "/api/v1/tokens", server.admin());
    EXPECT_EQ(list.body.find(secret), std::string::npos);
    EXPECT_EQ(list.body.find("secret"), std::string::npos);
}

TEST(AccessTest, ATokenInAnAddressIsRefused) {
    TestServer server;
    for (const char* name : {"token", "access_token"}) {
        const auto target = "/api/v1/dives?" + std::string(name) + "=" + server.admin();
        const auto response = server.request("GET", target, "");
        EXPECT_EQ(response.status, 400);
        EXPECT_EQ(response.body.find(server.admin()), std::string::npos);
    }
}

TEST(AccessTest, QueueingAReconstructionByUploadNeedsTheScopeForJobs) {
    TestServer server;
    const std::string token = server.make_token("reef", {"dives:write"});
    const auto response =
        RawClient(server.port())
            .request("POST",
                     "/api/v1/uploads",
                     tus_headers(
                         token,
                         {{"Upload-Length", "5"}, {"Upload-Metadata", "job " + base64("paper")}}));
    EXPECT_EQ(response.status, 403);
}

}  // namespace
}  // namespace divemesh
