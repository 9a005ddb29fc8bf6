// What pages of other origins may do.
#include <gtest/gtest.h>

#include "tests/server/test_server.hpp"

namespace divemesh {
namespace {

const std::string kLab = "https://lab.example";

server::ServerConfig lab_may() {
    server::ServerConfig config;
    config.allowed_origins = {kLab};
    return config;
}

RawResponse preflight(TestServer& server, const std::string& origin, const std::string& path) {
    return server.request(
        "OPTIONS", path, "", {{"Origin", origin}, {"Access-Control-Request-Method", "POST"}});
}

RawResponse open_socket(TestServer& server, const Headers& more) {
    Headers headers = {{"Upgrade", "websocket"},
                       {"Connection", "Upgrade"},
                       {"Sec-WebSocket-Version", "13"},
                       {"Sec-WebSocket-Key", "dGhlIHNhbXBsZSBub25jZQ=="},
                       {"Authorization", "Bearer " + server.admin()}};
    headers.insert(headers.end(), more.begin(), more.end());
    RawClient client(server.port());
    client.send(request_head("GET", "/api/v1/events", headers, std::nullopt));
    return client.receive().value_or(RawResponse{});
}

TEST(BrowserTest, NoOtherOriginIsLetInByDefault) {
    TestServer server;
    EXPECT_EQ(preflight(server, kLab, "/api/v1/dives").status, 405);
    const auto response = server.request("GET", "/healthz/live", "", {{"Origin", kLab}});
    EXPECT_EQ(response.header("access-control-allow-origin"), "");
}

TEST(BrowserTest, AnAnswerOfTheApiShownByItselfRunsNothingAndIsInNoFrame) {
    TestServer server;
    for (const char* path :
         {"/healthz/live", "/api/v1/dives", "/api/v1/nothing", "/openapi.json"}) {
        const auto response = server.request("GET", path, server.admin());
        const std::string policy = response.header("content-security-policy");
        EXPECT_TRUE(policy.starts_with("default-src 'none'; base-uri 'none'")) << path;
        EXPECT_NE(policy.find("frame-ancestors 'none'"), std::string::npos) << path;
        EXPECT_EQ(response.header("referrer-policy"), "no-referrer") << path;
        EXPECT_EQ(response.header("x-content-type-options"), "nosniff") << path;
    }
}

TEST(BrowserTest, NoCacheThatIsSharedKeepsAnAnswer) {
    TestServer server;
    const auto cached = [&](const char* path) {
        return server.request("GET", path, server.admin()).header("cache-control");
    };
    EXPECT_EQ(cached("/api/v1/dives"), "private, no-cache");
    EXPECT_EQ(cached("/api/v1/nothing"), "no-store");
    EXPECT_EQ(cached("/api/v1/session"), "no-store");
}

TEST(BrowserTest, TraceSendsNothingBack) {
    TestServer server;
    const auto response = server.request("TRACE", "/healthz/live", "", {{"X-Secret", "mine"}});
    EXPECT_EQ(response.status, 405);
    EXPECT_EQ(response.body.find("mine"), std::string::npos);
}

TEST(BrowserTest, OnlyOriginsOnTheListAreLetIn) {
    TestServer server(lab_may());
    const auto allowed = preflight(server, kLab, "/api/v1/dives");
    EXPECT_EQ(allowed.status, 204);
    EXPECT_EQ(allowed.header("access-control-allow-origin"), kLab);
    EXPECT_EQ(allowed.header("access-control-allow-methods"), "GET, POST");
    EXPECT_EQ(allowed.header("vary"), "Origin");
    EXPECT_NE(allowed.header("access-control-allow-headers").find("Upload-Offset"),
              std::string::npos);
    for (const char* origin :
         {"https://evil.example", "https://lab.example.evil", "http://lab.example", "null", ""}) {
        const auto refused = preflight(server, origin, "/api/v1/dives");
        EXPECT_EQ(refused.header("access-control-allow-origin"), "") << origin;
        EXPECT_EQ(refused.header("vary"), "Origin");
    }
    const auto read = server.request("GET", "/api/v1/dives", server.admin(), {{"Origin", kLab}});
    EXPECT_EQ(read.header("access-control-allow-origin"), kLab);
    EXPECT_EQ(read.header("access-control-allow-credentials"), "");
    EXPECT_EQ(preflight(server, kLab, "/nothing").status, 404);
    EXPECT_EQ(preflight(server, kLab, "/api/v1/uploads").status, 204);
}

// A page of another origin cannot open the event stream.
TEST(BrowserTest, AStreamIsForOurOwnPagesAndThoseOnTheList) {
    TestServer server(lab_may());
    EXPECT_EQ(open_socket(server, {}).status, 101);
    EXPECT_EQ(open_socket(server, {{"Origin", "http://127.0.0.1"}}).status, 101);
    EXPECT_EQ(open_socket(server, {{"Origin", kLab}}).status, 101);
    EXPECT_EQ(open_socket(server, {{"Origin", "https://evil.example"}}).status, 403);
    EXPECT_EQ(open_socket(server, {{"Origin", "null"}}).status, 403);
}

TEST(BrowserTest, ATraceIsCarriedOnUnlessItIsMalformed) {
    TestServer server;
    const auto echoed = [&](const std::string& trace) {
        return server.request("GET", "/healthz/live", "", {{"traceparent", trace}})
            .header("traceparent");
    };
    const std::string good = "00-4bf92f3577b34da6a3ce929d0e0e4736-00f067aa0ba902b7-01";
    EXPECT_EQ(echoed(good), good);
    EXPECT_EQ(echoed("00-4BF92F3577B34DA6A3CE929D0E0E4736-00f067aa0ba902b7-01"), "");
    EXPECT_EQ(echoed("x"), "");
    EXPECT_EQ(echoed(good + "0"), "");
}

TEST(BrowserTest, WhoKeepsGuessingTokensIsToldToWait) {
    server::ServerConfig config;
    config.max_failed_logins_per_s = 0.02;  // two at once
    TestServer server(config);
    for (int i = 0; i < 2; ++i)
        EXPECT_EQ(server.request("GET", "/api/v1/dives", "dm_guess").status, 401);
    const auto told = server.request("GET", "/api/v1/dives", "dm_guess");
    EXPECT_EQ(told.status, 429);
    EXPECT_NE(told.header("retry-after"), "");
    EXPECT_EQ(server.request("GET", "/api/v1/dives", server.admin()).status, 200);
}

TEST(BrowserTest, ATokenThatAsksTooOftenIsToldToWait) {
    server::ServerConfig config;
    config.max_requests_per_s = 0.5;  // one at once
    TestServer server(config);
    const std::string other = server.make_token("default", {"dives:read"});
    EXPECT_EQ(server.request("GET", "/api/v1/dives", server.admin()).status, 200);
    const auto told = server.request("GET", "/api/v1/dives", server.admin());
    EXPECT_EQ(told.status, 429);
    EXPECT_EQ(told.header("ratelimit-policy"), "\"token\";q=1;w=2");
    EXPECT_EQ(told.header("ratelimit"), "\"token\";r=0;t=2");
    EXPECT_EQ(told.header("retry-after"), "2");
    EXPECT_EQ(server.request("GET", "/api/v1/dives", other).status, 200);
}

}  // namespace
}  // namespace divemesh
