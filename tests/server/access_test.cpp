#include <gtest/gtest.h>

#include <map>
#include <optional>

#include "api/routes.hpp"
#include "storage/event_store.hpp"
#include "tests/server/sensor_fixture.hpp"

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

// Returns the path with the ids that exist; nullopt for a route about something without them.
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
    Headers headers = {
        {"Tus-Resumable", "1.0.0"},
        {"Upload-Offset", "0"},
        {"If-Match", "*"},
        {"Range", "bytes=0-0"},
        {"Content-Type", bytes ? "application/offset+octet-stream" : "application/json"}};
    if (route.kind != api::RouteKind::Secret)
        headers.emplace_back("Idempotency-Key", "\"access-test\"");
    return headers;
}

std::string any_body(const api::Route& route) {
    const bool bytes = route.path.find("uploads") != std::string_view::npos;
    const bool json = route.method == api::verb::post || route.method == api::verb::patch ||
                      route.method == api::verb::put;
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

TEST(AccessTest, EveryRouteOfTheApiWantsATokenThatItKnows) {
    ASSERT_FALSE(api::api_routes().empty());
    TestServer server;
    for (const api::Route& route : api::api_routes()) {
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
    ASSERT_FALSE(api::api_routes().empty());
    TestServer server;
    for (const auto known : kScopes) {
        const std::string scope(known);
        const std::string token = server.make_token("default", {scope});
        for (const api::Route& route : api::api_routes()) {
            if (route.scope.empty()) continue;
            const auto response = ask(server, route, token);
            if (scope == route.scope || scope == "admin" || route.scope == api::kAnyToken)
                EXPECT_NE(response.status, 403) << route.path << ' ' << scope;
            else
                EXPECT_EQ(response.status, 403) << route.path << ' ' << scope;
        }
    }
}

TEST(AccessTest, EveryScopeOpensARoute) {
    for (const auto scope : kScopes)
        EXPECT_TRUE(std::any_of(api::api_routes().begin(),
                                api::api_routes().end(),
                                [scope](const api::Route& route) { return route.scope == scope; }))
            << scope;
}

TEST(AccessTest, UnknownIdsAreNotFoundOnEveryRoute) {
    TestServer server;
    int num_routes = 0;
    for (const api::Route& route : api::api_routes()) {
        if (route.path.find('{') == std::string_view::npos || route.method == api::verb::options)
            continue;
        if (route.scope == "sensor:push") continue;  // creates the sensor that it names
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

class OtherProjectTest : public SensorFixture {
protected:
    // Makes one of each kind of object in the project "reef"; returns their ids.
    std::map<std::string, std::string> make_one_of_each() {
        const std::string job = server_.make_job("reef", "metrics.json", "{}");
        const std::string dive = asked("/api/v1/jobs/" + job)["dive_id"];
        const std::string upload = create_upload(server_.port(), mine_, 10);
        WebSocketClient sensor(
            server_.port(), sensor_token("buoy", "reef"), "/api/v1/sensors/buoy/stream");
        sensor.next_json();
        sensor.say(hello(0, {"preview"}));
        sensor.next_json();
        sensor.say_bytes(preview_frame(preview_header(1, {{"camera", "cam0"}}), jpeg()));
        sensor.next_json();
        return {
            {"dive_id", dive},
            {"job_id", job},
            {"upload_id", last_part(upload)},
            {"attempt", "1"},
            {"artifact_name...", "metrics.json"},
            {"truth_id", make_truth(dive)},
            {"share_id", made("/api/v1/jobs/" + job + "/shares", json::object())},
            {"schedule_id", made("/api/v1/schedules", {{"cron", "0 4 * * *"}, {"tag", "reef"}})},
            {"sensor_id", "buoy"},
            {"preview_id", asked("/api/v1/sensors/buoy/previews")["items"].at(0)["id"].dump()},
            {"command_id", made("/api/v1/sensors/buoy/commands", {{"name", "preview"}})}};
    }
    static std::string last_part(const std::string& path) {
        return path.substr(path.rfind('/') + 1);
    }
    json asked(const std::string& target) { return server_.request("GET", target, mine_).json(); }
    std::string made(const std::string& target, const json& body) {
        return server_.post_json(target, mine_, body).json().at("id");
    }
    std::string make_truth(const std::string& dive) {
        const std::string upload =
            create_upload(server_.port(),
                          mine_,
                          5,
                          "truth " + base64("ground_truth") + ",dive_id " + base64(dive) +
                              ",filename " + base64("tracker.tum"));
        return RawClient(server_.port())
            .request("PATCH", upload, patch_headers(mine_, 0), "poses")
            .header("divemesh-truth");
    }

    const std::vector<std::string> all_ = {
        "dives:read", "dives:write", "jobs:write", "sensor:command"};
    const std::string mine_ = server_.make_token("reef", all_);
    const std::string other_ = server_.make_token("wreck", all_);
};

// Checks every route that names an object, future ones too.
TEST_F(OtherProjectTest, WhatBelongsToAnotherProjectLooksAsIfItWereNotThere) {
    const std::map<std::string, std::string> ids = make_one_of_each();
    int num_routes = 0;
    for (const api::Route& route : api::api_routes()) {
        if (route.scope.empty() || route.scope == "admin") continue;
        if (route.scope == "sensor:push") continue;  // its token is for one sensor
        const auto path = filled_path(route.path, ids);
        ASSERT_TRUE(path) << route.path << ": make one of these in make_one_of_each()";
        if (*path == route.path) continue;
        ++num_routes;
        const auto refused = server_.request(std::string(api::http::to_string(route.method)),
                                             *path,
                                             other_,
                                             any_headers(route),
                                             any_body(route));
        EXPECT_EQ(refused.status, 404) << route.method << ' ' << *path;
        // It was refused for its project, as it is there. The dive has no thumbnail.
        const bool is_read = route.method == api::verb::get && !path->ends_with("thumbnail.jpg");
        EXPECT_TRUE(!is_read || server_.request("GET", *path, mine_).status != 404) << *path;
        EXPECT_EQ(refused.body.find("reef"), std::string::npos) << refused.body;
    }
    EXPECT_GE(num_routes, 25);
    const std::string upload = ids.at("upload_id");
    EXPECT_EQ(server_.post_json("/api/v1/dives", other_, {{"upload_id", upload}}).status, 404);
    for (const char* list :
         {"/api/v1/dives", "/api/v1/jobs", "/api/v1/schedules", "/api/v1/sensors"}) {
        EXPECT_EQ(server_.request("GET", list, other_).json()["items"].size(), 0U) << list;
        EXPECT_GT(asked(list)["items"].size(), 0U) << list;
        EXPECT_GT(get(list)["items"].size(), 0U) << list;
    }
    EXPECT_EQ(upload_offset(server_.port(), mine_, "/api/v1/uploads/" + upload), 0);
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
