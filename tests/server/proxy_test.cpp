// A server behind a proxy: the address that clients use, and who they are.
#include <gtest/gtest.h>

#include "api/public_url.hpp"
#include "schemas/error.hpp"
#include "server/forwarded.hpp"
#include "storage/event_store.hpp"
#include "tests/server/test_server.hpp"

namespace divemesh {
namespace {

server::ServerConfig behind_proxy() {
    server::ServerConfig config;
    config.public_url = "https://lab.example/dives/";
    config.trusted_proxies = {"127.0.0.1"};
    return config;
}

TEST(PublicUrlTest, AddressesAreThoseThatClientsUse) {
    TestServer server(behind_proxy());
    const std::string base = "https://lab.example/dives";
    const auto upload = server.request(
        "POST", "/api/v1/uploads", "", tus_headers(server.admin(), {{"Upload-Length", "5"}}));
    EXPECT_TRUE(upload.header("location").starts_with(base + "/api/v1/uploads/"));
    for (const char digit : {'a', 'b'}) server.make_dive("default", std::string(64, digit));
    const auto page = server.request("GET", "/api/v1/dives?limit=1", server.admin());
    EXPECT_TRUE(page.header("link").starts_with("<" + base + "/api/v1/dives?cursor="));
    const std::string job = "/api/v1/jobs/" + server.make_job("default", "report.html", "<p>");
    const auto share = server.post_json(job + "/shares", server.admin(), nlohmann::json::object());
    EXPECT_EQ(share.json()["url"], base + "/share#" + share.json()["secret"].get<std::string>());
    const std::string path = job + "/artifacts/report.html";
    const auto once =
        server.post_json("/api/v1/one_shot_tokens", server.admin(), {{"path", path}}).json();
    EXPECT_EQ(once["url"], base + path + "?one_shot=" + once["secret"].get<std::string>());
}

TEST(PublicUrlTest, IsAHostAndAPath) {
    EXPECT_EQ(api::checked_public_url("https://lab.example/"), "https://lab.example");
    EXPECT_EQ(api::checked_public_url("http://[::1]:8080/a/b"), "http://[::1]:8080/a/b");
    for (const char* wrong : {"lab.example",
                              "ftp://lab.example",
                              "https://",
                              "https:///dives",
                              "https://lab.example?x=1",
                              "https://lab.example/#x",
                              "https://user@lab.example",
                              "https://lab.example/a b",
                              "https://lab.example/\r\nX: y"})
        EXPECT_THROW(api::checked_public_url(wrong), Error) << wrong;
}

// The web page's files have addresses without the prefix, so the link has a page of its own.
TEST(PublicUrlTest, ASharingLinkUnderAPrefixHasAPageWithoutAbsoluteAddresses) {
    static constexpr api::PageFile kFiles[] = {{"index.html",
                                                "text/html; charset=utf-8",
                                                "0123456789abcdef0123456789abcdef",
                                                "<script src=\"/assets/main.js\">",
                                                ""}};
    server::ServerConfig config = behind_proxy();
    config.page = kFiles;
    TestServer server(config);
    EXPECT_EQ(server.request("GET", "/", "").body, kFiles[0].bytes);
    const auto page = server.request("GET", "/share", "");
    ASSERT_EQ(page.status, 200);
    EXPECT_EQ(page.header("content-type"), "text/html; charset=utf-8");
    EXPECT_NE(page.body.find("<script src=\"share.js\">"), std::string::npos) << page.body;
    EXPECT_EQ(page.body.find("=\"/"), std::string::npos) << page.body;
    const auto script = server.request("GET", "/share.js", "");
    ASSERT_EQ(script.status, 200);
    EXPECT_NE(script.body.find("ask(\"api/v1/session\""), std::string::npos);
    for (const char* absolute : {"\"/", "`/", "'/"})
        EXPECT_EQ(script.body.find(std::string(absolute) + "api"), std::string::npos);
    EXPECT_NE(page.header("content-security-policy").find("script-src 'self'"), std::string::npos);
}

// A proxy may send a Host of its own, so the page's Origin is not that.
TEST(PublicUrlTest, ItsOriginIsTheServersOwn) {
    server::ServerConfig config = behind_proxy();
    config.public_url = "https://Lab.example:443/dives";
    TestServer server(config);
    const auto begun = server.request("POST", "/api/v1/session", server.admin());
    ASSERT_EQ(begun.status, 201) << begun.body;
    const std::string set = begun.header("set-cookie");
    const auto change = [&](const std::string& origin) {
        return server
            .request("POST",
                     "/api/v1/queue/redrive",
                     "",
                     {{"Cookie", set.substr(0, set.find(';'))},
                      {"X-CSRF-Token", begun.json()["csrf_token"]},
                      {"Content-Type", "application/json"},
                      {"Origin", origin}},
                     "{}")
            .status;
    };
    EXPECT_EQ(change("https://lab.example"), 200);
    EXPECT_EQ(change("http://127.0.0.1"), 200) << "the Host of this request";
    for (const char* other : {"http://lab.example",
                              "https://lab.example:8443",
                              "https://lab.example.evil.example",
                              "https://evil.example",
                              "null"})
        EXPECT_EQ(change(other), 403) << other;
}

struct Client {
    std::string peer;
    bool is_https = false;
};

Client believed(const std::string& peer,
                std::map<std::string, std::string, std::less<>> headers,
                const std::vector<std::string>& trusted = {"127.0.0.1", "10.1.0.0/16"}) {
    api::Request request;
    request.peer = peer;
    request.headers = std::move(headers);
    server::believe_proxies(request, api::AllowedNetworks(trusted));
    return {request.peer, request.is_https};
}

TEST(ForwardedTest, ATrustedProxySaysWhoTheClientIs) {
    EXPECT_EQ(believed("127.0.0.1", {{"x-forwarded-for", "192.0.2.7"}}).peer, "192.0.2.7");
    EXPECT_EQ(believed("127.0.0.1", {{"x-forwarded-for", "192.0.2.7:4711"}}).peer, "192.0.2.7");
    EXPECT_EQ(believed("10.1.2.3", {{"x-forwarded-for", "2001:db8::7"}}).peer, "2001:db8::7");
    const auto tls =
        believed("127.0.0.1", {{"x-forwarded-for", "192.0.2.7"}, {"x-forwarded-proto", "https"}});
    EXPECT_TRUE(tls.is_https);
    EXPECT_EQ(believed("127.0.0.1", {}).peer, "127.0.0.1");
}

// The examples of RFC 7239, section 4 and 6.
TEST(ForwardedTest, TheStandardHeaderIsRead) {
    const auto peer = [](const std::string& header) {
        return believed("127.0.0.1", {{"forwarded", header}}).peer;
    };
    EXPECT_EQ(peer("For=\"[2001:db8:cafe::17]:4711\""), "2001:db8:cafe::17");
    EXPECT_EQ(peer("for=192.0.2.60;proto=http;by=203.0.113.43"), "192.0.2.60");
    EXPECT_EQ(peer("for=192.0.2.43, for=198.51.100.17"), "198.51.100.17");
    EXPECT_EQ(peer("for=\"192.0.2.43:47011\""), "192.0.2.43");
    EXPECT_EQ(peer("for=\"_gazonk\""), "127.0.0.1");
    EXPECT_EQ(peer("for=unknown"), "127.0.0.1");
    EXPECT_TRUE(believed("127.0.0.1", {{"forwarded", "for=192.0.2.60;proto=https"}}).is_https);
}

TEST(ForwardedTest, WhatAClientMakesUpCountsForNothing) {
    EXPECT_EQ(
        believed("127.0.0.1",
                 {{"forwarded", "for=203.0.113.9;proto=https"}, {"x-forwarded-for", "192.0.2.7"}})
            .peer,
        "192.0.2.7")
        << "a proxy that sets X-Forwarded-For passes on the other one as the client sent it";
    EXPECT_EQ(believed("192.0.2.1", {{"x-forwarded-for", "10.1.0.1"}}).peer, "192.0.2.1");
    EXPECT_EQ(believed("127.0.0.1", {{"x-forwarded-for", "1.1.1.1, 192.0.2.7"}}).peer, "192.0.2.7");
    EXPECT_EQ(believed("127.0.0.1", {{"x-forwarded-for", "1.1.1.1, 192.0.2.7, 10.1.0.9"}}).peer,
              "192.0.2.7");
    EXPECT_EQ(believed("127.0.0.1", {{"x-forwarded-for", "'; DROP TABLE"}}).peer, "127.0.0.1");
    EXPECT_FALSE(believed("192.0.2.1", {{"forwarded", "for=1.1.1.1;proto=https"}}).is_https);
}

TEST(ForwardedTest, FailedLoginsAreThoseOfTheClientNotOfTheProxy) {
    auto config = behind_proxy();
    config.max_failed_logins_per_s = 0.01;  // one in a burst
    TestServer server(config);
    const auto login = [&](const std::string& client) {
        return server.request("GET", "/api/v1/dives", "dm_wrong", {{"X-Forwarded-For", client}})
            .status;
    };
    EXPECT_EQ(login("192.0.2.1"), 401);
    EXPECT_EQ(login("192.0.2.1"), 429);
    EXPECT_EQ(login("192.0.2.2"), 401);
}

TEST(ForwardedTest, TheAuditTellsTheClient) {
    TestServer server(behind_proxy());
    server.request("POST",
                   "/api/v1/tokens",
                   server.admin(),
                   {{"X-Forwarded-For", "192.0.2.9"}, {"Content-Type", "application/json"}},
                   R"({"name": "x", "scopes": ["dives:read"]})");
    EXPECT_EQ(storage::EventStore(server.catalog()).since(0, "", 100).back().data["peer"],
              "192.0.2.9");
}

}  // namespace
}  // namespace divemesh
