#include <gtest/gtest.h>

#include <map>
#include <optional>

#include "api/routes.hpp"
#include "storage/event_store.hpp"
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

// Returns the path with the ids that exist; nullopt for a route about something else.
std::optional<std::string> filled_path(std::string_view pattern,
                                       const std::map<std::string, std::string>& ids) {
    std::string path;
    while (!pattern.empty()) {
        const auto brace = pattern.find('{');
        path += pattern.substr(0, brace);
        if (brace == std::string_view::npos) break;
        const auto end = pattern.find('}', brace);
        const auto id = ids.find(std::string(pattern.substr(brace + 1, end - brace - 1)));
        if (id == ids.end()) return std::nullopt;
        path += id->second;
        pattern.remove_prefix(end + 1);
    }
    return path;
}

// Returns headers with which a request of the route passes the checks before that of its subject.
Headers any_headers(const api::Route& route) {
    const bool bytes =
        route.method == api::verb::patch && route.path.find("uploads") != std::string_view::npos;
    return {{"Tus-Resumable", "1.0.0"},
            {"Upload-Offset", "0"},
            {"If-Match", "*"},
            {"Idempotency-Key", "\"access-test\""},
            {"Range", "bytes=0-0"},
            {"Content-Type", bytes ? "application/offset+octet-stream" : "application/json"}};
}

std::string any_body(const api::Route& route) {
    const bool bytes = route.path.find("uploads") != std::string_view::npos;
    const bool json = route.method == api::verb::post || route.method == api::verb::patch;
    return json && !bytes ? "{}" : "";
}

RawResponse ask(const TestServer& server, const api::Route& route, const std::string& token) {
    return server.request(
        std::string(api::http::to_string(route.method)),
        some_path(route.path),
        token,
        {{"Tus-Resumable", "1.0.0"}, {"Content-Type", "application/json"}, {"Upload-Length", "0"}},
        "");
}

// S26
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

// S24
TEST(AccessTest, EveryRouteWantsItsScopeAndNoOther) {
    TestServer server;
    for (const auto known : kScopes) {
        const std::string scope(known);
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
    int num_routes = 0;
    for (const api::Route& route : api::routes()) {
        if (route.path.find('{') == std::string_view::npos || route.method == api::verb::options)
            continue;
        if (route.scope == "sensor:push") continue;  // what it names comes into being by it
        ++num_routes;
        const auto response = server.request(std::string(api::http::to_string(route.method)),
                                             some_path(route.path),
                                             server.admin(),
                                             any_headers(route),
                                             any_body(route));
        EXPECT_EQ(response.status, 404) << route.path;
    }
    EXPECT_GE(num_routes, 13);
}

// S13: every route that names an object, those of tomorrow too.
TEST(AccessTest, WhatBelongsToAnotherProjectLooksAsIfItWereNotThere) {
    TestServer server;
    const std::vector<std::string> all = {"dives:read", "dives:write", "jobs:write"};
    const std::string mine = server.make_token("reef", all);
    const std::string other = server.make_token("wreck", all);
    const std::string job = server.make_job("reef", "metrics.json", "{}");
    const std::string dive = server.request("GET", "/api/v1/jobs/" + job, mine).json()["dive_id"];
    const std::string upload = create_upload(server.port(), mine, 10);
    const std::map<std::string, std::string> ids = {
        {"dive_id", dive},
        {"job_id", job},
        {"upload_id", upload.substr(upload.rfind('/') + 1)},
        {"attempt", "1"},
        {"artifact_name...", "metrics.json"}};
    int num_routes = 0;
    for (const api::Route& route : api::routes()) {
        if (route.scope.empty() || route.scope == "admin") continue;
        const auto path = filled_path(route.path, ids);
        if (!path || *path == route.path) continue;
        ++num_routes;
        const auto refused = server.request(std::string(api::http::to_string(route.method)),
                                            *path,
                                            other,
                                            any_headers(route),
                                            any_body(route));
        EXPECT_EQ(refused.status, 404) << route.method << ' ' << *path;
        EXPECT_EQ(refused.body.find("reef"), std::string::npos) << refused.body;
    }
    EXPECT_GE(num_routes, 13);
    const auto made = server.post_json(
        "/api/v1/dives", other, {{"upload_id", upload.substr(upload.rfind('/') + 1)}});
    EXPECT_EQ(made.status, 404);
    for (const char* list : {"/api/v1/dives", "/api/v1/jobs"}) {
        EXPECT_EQ(server.request("GET", list, other).json()["items"].size(), 0U);
        EXPECT_GT(server.request("GET", list, mine).json()["items"].size(), 0U);
        EXPECT_GT(server.request("GET", list, server.admin()).json()["items"].size(), 0U);
    }
    EXPECT_EQ(upload_offset(server.port(), mine, upload), 0);
}

// A8
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

// S24
TEST(AccessTest, ATokenInAnAddressIsRefused) {
    TestServer server;
    for (const char* name : {"token", "access_token"}) {
        const auto target = "/api/v1/dives?" + std::string(name) + "=" + server.admin();
        const auto response = server.request("GET", target, "");
        EXPECT_EQ(response.status, 400);
        EXPECT_EQ(response.body.find(server.admin()), std::string::npos);
    }
}

TEST(AccessTest, AdministratorsAreToldWhoChangedWhat) {
    TestServer server;
    storage::EventStore events(server.catalog());
    const auto before = events.newest_sequence();
    const auto made = server.post_json(
        "/api/v1/tokens", server.admin(), {{"name", "laptop"}, {"scopes", {"dives:read"}}});
    server.request("GET", "/api/v1/tokens", server.admin());
    server.post_json("/api/v1/tokens", made.json()["secret"], {{"name", "more"}});
    std::vector<Event> audits;
    for (const Event& event : events.since(before, "", 100))
        if (event.topic == "audit") audits.push_back(event);
    ASSERT_EQ(audits.size(), 1U);
    EXPECT_EQ(audits[0].project, "");
    EXPECT_EQ(audits[0].data["path"], "/api/v1/tokens");
    EXPECT_EQ(audits[0].data["method"], "POST");
    EXPECT_EQ(audits[0].data["request_id"], made.header("x-request-id"));
    EXPECT_EQ(audits[0].data["peer"], "127.0.0.1");
    EXPECT_EQ(audits[0].data.dump().find("dm_"), std::string::npos);
    EXPECT_TRUE(storage::EventStore(server.catalog()).since(0, "default", 100).empty());
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
