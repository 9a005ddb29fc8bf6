// Browsers sign in with a token and are known by a cookie from then on: what it opens, what it does
// not, and when it ends.
#include <gtest/gtest.h>

#include <soci/soci.h>
#include <spdlog/sinks/ostream_sink.h>
#include <spdlog/spdlog.h>
#include <sstream>

#include "api/browser_session.hpp"
#include "storage/browser_session_store.hpp"
#include "storage/token_store.hpp"
#include "tests/server/test_server.hpp"

namespace divemesh {
namespace {

const std::string kSession = "/api/v1/session";

class SessionTest : public testing::Test {
protected:
    explicit SessionTest(const server::ServerConfig& config = {}) : server(config) {}

    // A browser: its cookie, and what a page knows of the session.
    struct Browser {
        std::string cookie;  // "divemesh_session=..."
        std::string csrf_token;
    };

    static std::string cookie_of(const RawResponse& response) {
        const std::string all = response.header("set-cookie");
        return all.substr(0, all.find(';'));
    }
    RawResponse post_session(const std::string& secret, const Headers& more = {}) const {
        return server.request("POST", kSession, secret, more);
    }
    Browser sign_in(const std::string& secret) const {
        const auto response = post_session(secret);
        EXPECT_EQ(response.status, 201) << response.body;
        return {cookie_of(response), response.json()["csrf_token"]};
    }
    RawResponse ask(const Browser& browser,
                    const std::string& method,
                    const std::string& target,
                    Headers more = {},
                    std::string_view body = {}) const {
        more.emplace_back("Cookie", browser.cookie);
        return server.request(method, target, "", more, body);
    }
    // As the page does it.
    RawResponse change(const Browser& browser,
                       const std::string& method,
                       const std::string& target,
                       Headers more = {},
                       std::string_view body = {}) const {
        more.emplace_back("X-CSRF-Token", browser.csrf_token);
        return ask(browser, method, target, more, body);
    }
    void set_clock_back(const std::string& column, std::chrono::milliseconds age) {
        server.catalog().transaction([&](soci::session& session) {
            session << "UPDATE browser_sessions SET " << column << " = " << column << " - "
                    << age.count();
        });
    }
    int num_sessions() {
        int num = 0;
        server.catalog().read([&](soci::session& session) {
            session << "SELECT COUNT(*) FROM browser_sessions", soci::into(num);
        });
        return num;
    }
    std::pair<std::string, std::string> new_token(std::int64_t expires_in_s = 0) {
        const auto made = server.post_json(
            "/api/v1/tokens",
            server.admin(),
            {{"name", "lab"}, {"scopes", {"dives:read"}}, {"expires_in_s", expires_in_s}});
        return {made.json()["id"], made.json()["secret"]};
    }

    TestServer server;
    const std::string editor =
        server.make_token("reef", {"dives:read", "dives:write", "jobs:write"});
};

TEST_F(SessionTest, SigningInGivesACookieThatScriptsCannotRead) {
    const auto response = post_session(editor);
    EXPECT_EQ(response.status, 201) << response.body;
    const std::string cookie = response.header("set-cookie");
    const std::string secret = cookie_of(response).substr(std::string("divemesh_session=").size());
    EXPECT_EQ(secret.size(), 64U) << cookie;
    EXPECT_EQ(secret.find_first_not_of("0123456789abcdef"), std::string::npos);
    for (const char* attribute : {"; Path=/", "; HttpOnly", "; SameSite=Strict"})
        EXPECT_NE(cookie.find(attribute), std::string::npos) << cookie;
    EXPECT_EQ(cookie.find("Secure"), std::string::npos) << "this server has no TLS: " << cookie;
    EXPECT_EQ(response.header("cache-control"), "no-store");
    const auto body = response.json();
    EXPECT_EQ(body["name"], "test");
    EXPECT_EQ(body["project"], "reef");
    EXPECT_EQ(body["scopes"], nlohmann::json({"dives:read", "dives:write", "jobs:write"}));
    EXPECT_GE(body["csrf_token"].get<std::string>().size(), 32U);
    EXPECT_EQ(response.body.find(secret), std::string::npos);
    EXPECT_EQ(response.body.find(editor), std::string::npos);
    EXPECT_NE(post_session(editor).header("set-cookie"), cookie);
}

class SessionBehindProxyTest : public SessionTest {
protected:
    static server::ServerConfig proxied() {
        server::ServerConfig config;
        config.trusted_proxies = {"127.0.0.1"};
        return config;
    }
    SessionBehindProxyTest() : SessionTest(proxied()) {}
};

TEST_F(SessionBehindProxyTest, TheCookieIsForTlsAloneIfTheProxySpeaksIt) {
    const auto response =
        post_session(editor, {{"X-Forwarded-For", "192.0.2.7"}, {"X-Forwarded-Proto", "https"}});
    EXPECT_TRUE(response.header("set-cookie").ends_with("; Secure"));
    EXPECT_TRUE(response.header("set-cookie").starts_with("__Host-divemesh_session="));
}

TEST_F(SessionTest, ASharingLinkOpensItsJobAloneUntilItIsWithdrawn) {
    const std::string job_id = server.make_job("reef", "mesh.glb", "glTF");
    const std::string job = "/api/v1/jobs/" + job_id;
    const auto share = server.post_json(job + "/shares", editor, nlohmann::json::object()).json();
    const Browser browser = sign_in(share["secret"]);

    const auto who = ask(browser, "GET", kSession).json();
    EXPECT_EQ(who["shared_job"], job_id);
    EXPECT_EQ(ask(browser, "GET", job).status, 200);
    EXPECT_EQ(ask(browser, "GET", job + "/artifacts/mesh.glb").body, "glTF");
    EXPECT_EQ(ask(browser, "GET", "/api/v1/dives").status, 403);
    EXPECT_EQ(change(browser, "POST", job + "/retry").status, 403);

    const std::string id = share["id"];
    EXPECT_EQ(server.request("DELETE", job + "/shares/" + id, editor, {{"If-Match", "*"}}).status,
              204);
    EXPECT_EQ(ask(browser, "GET", job).status, 401);
}

TEST_F(SessionTest, ACatalogHoldsNoSecretOfASession) {
    const Browser browser = sign_in(editor);
    std::string stored;
    server.catalog().read([&](soci::session& session) {
        session << "SELECT secret_sha256 FROM browser_sessions", soci::into(stored);
    });
    EXPECT_EQ(browser.cookie.find(stored), std::string::npos);
    EXPECT_EQ(stored, sha256_hex(browser.cookie.substr(browser.cookie.find('=') + 1)));
}

TEST_F(SessionTest, OnlyATokenBeginsASession) {
    EXPECT_EQ(post_session("").status, 401);
    EXPECT_EQ(post_session("dm_wrong").status, 401);
    EXPECT_EQ(post_session("dm1_wrong").status, 401);
    const Browser browser = sign_in(editor);
    EXPECT_EQ(change(browser, "POST", kSession).status, 401);
    EXPECT_EQ(num_sessions(), 1);
}

TEST_F(SessionTest, ACookieOpensWhatItsTokenOpens) {
    const Browser browser = sign_in(editor);
    EXPECT_EQ(ask(browser, "GET", "/api/v1/dives").status, 200);
    EXPECT_EQ(ask(browser, "GET", "/api/v1/tokens").status, 403);
    const std::string mine = server.make_dive("reef", sha256_hex("a"));
    const std::string other = server.make_dive("wreck", sha256_hex("b"));
    EXPECT_EQ(ask(browser, "GET", "/api/v1/dives/" + mine).status, 200);
    EXPECT_EQ(ask(browser, "GET", "/api/v1/dives/" + other).status, 404);
    const std::string job = server.make_job("reef", "mesh.glb", "glTF");
    EXPECT_EQ(ask(browser, "GET", "/api/v1/jobs/" + job + "/artifacts/mesh.glb").body, "glTF");
}

TEST_F(SessionTest, CookiesOfOthersBesideItDoNotMatter) {
    Browser browser = sign_in(editor);
    browser.cookie = "theme=dark; x_divemesh_session=1;  " + browser.cookie + " ;a=\"b\"; c";
    EXPECT_EQ(ask(browser, "GET", "/api/v1/dives").status, 200);
    for (const char* wrong :
         {"divemesh_session", "divemesh_session=", "divemesh_session=x", "=", ";;"})
        EXPECT_EQ(ask({wrong, ""}, "GET", "/api/v1/dives").status, 401) << wrong;
}

TEST_F(SessionTest, ATokenCountsBeforeACookie) {
    const Browser browser = sign_in(editor);
    const Headers cookie = {{"Cookie", browser.cookie}};
    EXPECT_EQ(server.request("GET", "/api/v1/dives", "dm_wrong", cookie).status, 401);
    EXPECT_EQ(server.request("GET", "/api/v1/tokens", server.admin(), cookie).status, 200);
    const auto made = server.request("POST",
                                     "/api/v1/tokens",
                                     server.admin(),
                                     {{"Cookie", browser.cookie},
                                      {"Origin", "http://127.0.0.1"},
                                      {"Content-Type", "application/json"}},
                                     R"({"name": "x", "scopes": ["dives:read"]})");
    EXPECT_EQ(made.status, 201) << made.body;
}

TEST_F(SessionTest, AReloadedPageGetsTheSameCsrfToken) {
    const auto begun = post_session(editor);
    const Browser browser{cookie_of(begun), begun.json()["csrf_token"]};
    const auto again = ask(browser, "GET", kSession);
    EXPECT_EQ(again.status, 200);
    EXPECT_EQ(again.json(), begun.json());
    EXPECT_EQ(again.header("cache-control"), "no-store");
    EXPECT_EQ(ask({}, "GET", kSession).status, 401);
    const auto by_token = server.request("GET", kSession, editor);
    EXPECT_EQ(by_token.status, 200);
    EXPECT_EQ(by_token.json()["csrf_token"], "");
}

TEST_F(SessionTest, WhatChangesSomethingNeedsTheCsrfTokenOfThisSession) {
    const Browser browser = sign_in(editor);
    const Browser other = sign_in(editor);
    const std::string dive = "/api/v1/dives/" + server.make_dive("reef", sha256_hex("a"));
    const Headers json = {{"Content-Type", "application/json"}, {"If-Match", "*"}};
    for (const auto& [method, target] : {std::pair<std::string, std::string>{"DELETE", dive},
                                         {"POST", dive + "/jobs"},
                                         {"PATCH", "/api/v1/jobs/job_x"},
                                         {"DELETE", kSession}}) {
        const auto without = ask(browser, method, target, json, "{}");
        EXPECT_EQ(without.status, 403) << method << ' ' << target;
        EXPECT_NE(without.body.find("X-CSRF-Token"), std::string::npos) << without.body;
        for (const std::string& wrong : {other.csrf_token, std::string("x"), std::string()}) {
            Headers headers = json;
            headers.emplace_back("X-CSRF-Token", wrong);
            EXPECT_EQ(ask(browser, method, target, headers, "{}").status, 403) << target;
        }
    }
    EXPECT_EQ(change(browser, "POST", dive + "/jobs", json, "{}").status, 201);
    EXPECT_EQ(ask(browser, "GET", dive).status, 200);
    EXPECT_EQ(ask(browser, "HEAD", dive).status, 200);
}

TEST_F(SessionTest, APageOfAnotherOriginChangesNothing) {
    const Browser browser = sign_in(editor);
    const std::string dive = "/api/v1/dives/" + server.make_dive("reef", sha256_hex("a"));
    for (const char* origin : {"https://evil.example",
                               "null",
                               "http://127.0.0.1.evil.example",
                               "http://127.0.0.1:1",
                               "127.0.0.1",
                               ""}) {
        const auto refused =
            change(browser, "DELETE", dive, {{"Origin", origin}, {"If-Match", "*"}});
        EXPECT_EQ(refused.status, 403) << origin;
        EXPECT_NE(refused.body.find("Origin"), std::string::npos) << refused.body;
    }
    EXPECT_EQ(
        change(browser, "DELETE", dive, {{"Origin", "http://127.0.0.1"}, {"If-Match", "*"}}).status,
        200);
}

class SessionWithOriginsTest : public SessionTest {
protected:
    static server::ServerConfig lab_may() {
        server::ServerConfig config;
        config.allowed_origins = {"https://lab.example"};
        return config;
    }
    SessionWithOriginsTest() : SessionTest(lab_may()) {}

    int open_events(const Headers& more) {
        Headers headers = {{"Upgrade", "websocket"},
                           {"Connection", "Upgrade"},
                           {"Sec-WebSocket-Version", "13"},
                           {"Sec-WebSocket-Key", "dGhlIHNhbXBsZSBub25jZQ=="}};
        headers.insert(headers.end(), more.begin(), more.end());
        RawClient client(server.port());
        client.send(request_head("GET", "/api/v1/events", headers, std::nullopt));
        return client.receive().value_or(RawResponse{}).status;
    }
};

TEST_F(SessionWithOriginsTest, AStreamByCookieIsForPagesOfThisServerAlone) {
    const Browser browser = sign_in(editor);
    const auto open = [&](const Headers& origin) {
        Headers headers = {{"Cookie", browser.cookie}};
        headers.insert(headers.end(), origin.begin(), origin.end());
        return open_events(headers);
    };
    EXPECT_EQ(open({{"Origin", "http://127.0.0.1"}}), 101);
    EXPECT_EQ(open({}), 403);
    EXPECT_EQ(open({{"Origin", "https://evil.example"}}), 403);
    EXPECT_EQ(open({{"Origin", "null"}}), 403);
    EXPECT_EQ(open({{"Origin", "https://lab.example"}}), 403) << "such a page has to bring a token";
    const Headers token = {{"Authorization", "Bearer " + editor}};
    EXPECT_EQ(open_events(token), 101);
}

TEST_F(SessionWithOriginsTest, AListedPageOfAnotherOriginCannotUseACookie) {
    const Browser browser = sign_in(editor);
    const std::string dive = "/api/v1/dives/" + server.make_dive("reef", sha256_hex("a"));
    const Headers lab = {{"Origin", "https://lab.example"}, {"If-Match", "*"}};
    EXPECT_EQ(change(browser, "DELETE", dive, lab).status, 403);
    EXPECT_EQ(ask(browser, "GET", dive, lab).header("access-control-allow-credentials"), "");
}

TEST_F(SessionTest, UploadsArriveByCookieInPieces) {
    const Browser browser = sign_in(editor);
    const Headers tus = {{"Tus-Resumable", "1.0.0"}};
    const auto with = [&](Headers more) {
        more.insert(more.end(), tus.begin(), tus.end());
        return more;
    };
    const Headers creation = with({{"Upload-Length", "10"}});
    EXPECT_EQ(ask(browser, "POST", "/api/v1/uploads", creation).status, 403);
    const auto made = change(browser, "POST", "/api/v1/uploads", creation);
    ASSERT_EQ(made.status, 201) << made.body;
    const std::string path = made.header("location");
    const auto bytes_at = [&](const std::string& offset) {
        return with(
            {{"Upload-Offset", offset}, {"Content-Type", "application/offset+octet-stream"}});
    };
    EXPECT_EQ(ask(browser, "PATCH", path, bytes_at("0"), "hello").status, 403);
    EXPECT_EQ(change(browser, "PATCH", path, bytes_at("0"), "hello").status, 204);
    EXPECT_EQ(ask(browser, "HEAD", path, tus).header("upload-offset"), "5");
    Headers overridden = bytes_at("5");
    overridden.emplace_back("X-HTTP-Method-Override", "PATCH");
    EXPECT_EQ(ask(browser, "POST", path, overridden, "there").status, 403);
    EXPECT_EQ(change(browser, "POST", path, overridden, "there").status, 204);
    const std::string second =
        change(browser, "POST", "/api/v1/uploads", creation).header("location");
    EXPECT_EQ(ask(browser, "DELETE", second, tus).status, 403);
    EXPECT_EQ(change(browser, "DELETE", second, tus).status, 204);
}

TEST_F(SessionTest, SigningOutEndsItAndTheBrowserForgetsTheCookie) {
    const Browser browser = sign_in(editor);
    const Browser other = sign_in(editor);
    const auto out = change(browser, "DELETE", kSession);
    EXPECT_EQ(out.status, 204);
    EXPECT_TRUE(out.header("set-cookie").starts_with("divemesh_session=; Path=/; Max-Age=0"));
    EXPECT_EQ(out.header("clear-site-data"), "\"cache\"");
    EXPECT_EQ(ask(browser, "GET", "/api/v1/dives").status, 401);
    EXPECT_EQ(change(browser, "DELETE", kSession).status, 401);
    EXPECT_EQ(ask(other, "GET", "/api/v1/dives").status, 200);
}

TEST_F(SessionTest, ASessionEndsAtOnceWithItsToken) {
    const auto [id, secret] = new_token();
    const Browser browser = sign_in(secret);
    EXPECT_EQ(ask(browser, "GET", "/api/v1/dives").status, 200);
    EXPECT_EQ(server.request("DELETE", "/api/v1/tokens/" + id, server.admin()).status, 204);
    EXPECT_EQ(ask(browser, "GET", "/api/v1/dives").status, 401);
    EXPECT_EQ(ask(browser, "GET", kSession).status, 401);
}

TEST_F(SessionTest, ASessionEndsNoLaterThanItsToken) {
    const auto [id, secret] = new_token(3600);
    const auto begun = post_session(secret);
    const std::int64_t end_ms = begun.json()["expires_at_ms"];
    const auto tokens = server.request("GET", "/api/v1/tokens", server.admin()).json()["items"];
    EXPECT_EQ(end_ms, tokens.back()["expires_at_ms"]);
    const Browser browser{cookie_of(begun), ""};
    server.catalog().transaction([](soci::session& session) {
        session << "UPDATE tokens SET expires_at_ms = 1 WHERE expires_at_ms > 0";
    });
    EXPECT_EQ(ask(browser, "GET", "/api/v1/dives").status, 401);
}

TEST_F(SessionTest, ASessionEndsAfterADayWithoutARequest) {
    using namespace std::chrono_literals;
    const Browser browser = sign_in(editor);
    set_clock_back("last_used_at_ms", 23h);
    EXPECT_EQ(ask(browser, "GET", "/api/v1/dives").status, 200);
    set_clock_back("last_used_at_ms", 23h);
    EXPECT_EQ(ask(browser, "GET", "/api/v1/dives").status, 200) << "the first one was noted";
    set_clock_back("last_used_at_ms", 24h);
    EXPECT_EQ(ask(browser, "GET", "/api/v1/dives").status, 401);
}

TEST_F(SessionTest, ASessionEndsAfterThirtyDaysHoweverOftenItIsUsed) {
    using namespace std::chrono_literals;
    const Browser browser = sign_in(editor);
    set_clock_back("created_at_ms", 24h * 29);
    EXPECT_EQ(ask(browser, "GET", "/api/v1/dives").status, 200);
    set_clock_back("created_at_ms", 24h);
    EXPECT_EQ(ask(browser, "GET", "/api/v1/dives").status, 401);
}

TEST_F(SessionTest, HousekeepingForgetsWhatHasEnded) {
    using namespace std::chrono_literals;
    storage::BrowserSessionStore sessions(server.catalog());
    const auto [id, secret] = new_token();
    sign_in(secret);
    sign_in(editor);
    set_clock_back("last_used_at_ms", 25h);
    const Browser open = sign_in(editor);
    const auto [revoked_id, revoked] = new_token();
    sign_in(revoked);
    EXPECT_EQ(num_sessions(), 4);
    EXPECT_EQ(server.request("DELETE", "/api/v1/tokens/" + revoked_id, server.admin()).status, 204);
    sessions.forget_ended();
    EXPECT_EQ(num_sessions(), 1);
    EXPECT_EQ(ask(open, "GET", "/api/v1/dives").status, 200);
}

TEST_F(SessionTest, ATokenHasAHundredSessionsAndItsOldestOneGivesWay) {
    storage::BrowserSessionStore sessions(server.catalog());
    const auto token = storage::TokenStore(server.catalog()).find(editor);
    const auto other = storage::TokenStore(server.catalog()).find(server.admin());
    const auto untouched = sessions.create(*other);
    const auto first = sessions.create(*token);
    const auto second = sessions.create(*token);
    for (int i = 0; i < 99; ++i) sessions.create(*token);
    EXPECT_FALSE(sessions.find(first.secret));
    EXPECT_TRUE(sessions.find(second.secret));
    EXPECT_TRUE(sessions.find(untouched.secret));
}

TEST_F(SessionTest, ALinkSignsInOnceWithTheRightsOfItsToken) {
    const auto made =
        server.post_json("/api/v1/one_shot_tokens", editor, {{"path", "/api/v1/session"}});
    ASSERT_EQ(made.status, 201) << made.body;
    const std::string secret = made.json()["secret"];
    EXPECT_EQ(server.request("GET", "/api/v1/dives", secret).status, 401);
    EXPECT_EQ(server.request("GET", kSession, secret).status, 401);
    EXPECT_EQ(server.request("POST", kSession + "?one_shot=" + secret, "").status, 400);
    const auto begun = post_session(secret);
    ASSERT_EQ(begun.status, 201) << begun.body;
    EXPECT_EQ(begun.json()["project"], "reef");
    EXPECT_EQ(ask({cookie_of(begun), ""}, "GET", "/api/v1/dives").status, 200);
    EXPECT_EQ(post_session(secret).status, 401);
}

TEST_F(SessionTest, OfManyWhoRaceForALinkOneIsSignedIn) {
    const auto made =
        server.post_json("/api/v1/one_shot_tokens", editor, {{"path", "/api/v1/session"}});
    const std::string secret = made.json()["secret"];
    std::atomic<int> signed_in = 0;
    {
        std::vector<std::jthread> threads;
        for (int i = 0; i < 8; ++i)
            threads.emplace_back([&] { signed_in += post_session(secret).status == 201 ? 1 : 0; });
    }
    EXPECT_EQ(signed_in, 1);
    EXPECT_EQ(num_sessions(), 1);
}

TEST_F(SessionTest, ALinkOfTheCommandLineIsOfAnAdministratorAndLastsAQuarterOfAnHour) {
    const std::string path = api::make_sign_in_path(server.catalog(), "", "test");
    ASSERT_TRUE(path.starts_with("/sign-in#dm1_")) << path;
    std::int64_t left_ms = 0;
    server.catalog().read([&](soci::session& session) {
        session << "SELECT expires_at_ms FROM one_shot_tokens", soci::into(left_ms);
        left_ms -= storage::Catalog::now_ms(session);
    });
    EXPECT_GT(left_ms, 14 * 60'000);
    EXPECT_LE(left_ms, 15 * 60'000);
    const auto begun = post_session(path.substr(path.find('#') + 1));
    ASSERT_EQ(begun.status, 201) << begun.body;
    EXPECT_EQ(begun.json()["scopes"], nlohmann::json({"admin"}));
    EXPECT_THROW(api::make_sign_in_path(server.catalog(), "token_none", "test"), Error);
}

TEST_F(SessionTest, ALinkOfARevokedTokenSignsNobodyIn) {
    const auto [id, secret] = new_token();
    const std::string path = api::make_sign_in_path(server.catalog(), id, "test");
    EXPECT_EQ(server.request("DELETE", "/api/v1/tokens/" + id, server.admin()).status, 204);
    EXPECT_EQ(post_session(path.substr(path.find('#') + 1)).status, 401);
}

TEST_F(SessionTest, NoSecretOfASessionReachesTheLog) {
    std::ostringstream log;
    const auto before = spdlog::default_logger();
    spdlog::set_default_logger(std::make_shared<spdlog::logger>(
        "test", std::make_shared<spdlog::sinks::ostream_sink_mt>(log)));
    const Browser browser = sign_in(editor);
    ask(browser, "GET", "/api/v1/dives");
    ask(browser, "DELETE", kSession);
    server.stop();
    spdlog::set_default_logger(before);
    EXPECT_NE(log.str().find("\"event\":\"request\""), std::string::npos);
    EXPECT_EQ(log.str().find(browser.cookie.substr(browser.cookie.find('=') + 1)),
              std::string::npos);
    EXPECT_EQ(log.str().find(browser.csrf_token), std::string::npos);
}

TEST(OpenSessionTest, WithoutAuthenticationEverybodyIsSignedIn) {
    server::ServerConfig config;
    config.no_auth = true;
    TestServer server(config);
    const auto shown = server.request("GET", kSession, "");
    EXPECT_EQ(shown.status, 200);
    EXPECT_EQ(shown.json()["scopes"], nlohmann::json({"admin"}));
    const auto begun = server.request("POST", kSession, "");
    EXPECT_EQ(begun.status, 201) << begun.body;
    EXPECT_EQ(begun.header("set-cookie"), "");
    EXPECT_EQ(server.request("DELETE", kSession, "").status, 204);
}

TEST(OpenSessionTest, WithoutAuthenticationAPageOfAnotherOriginChangesNothing) {
    server::ServerConfig config;
    config.no_auth = true;
    config.allowed_origins = {"https://lab.example"};
    TestServer server(config);
    const auto redrive = [&](const Headers& headers) {
        return server.request("POST", "/api/v1/queue/redrive", "", headers).status;
    };
    EXPECT_EQ(redrive({{"Origin", "https://evil.example"}}), 403);
    EXPECT_EQ(redrive({{"Origin", "null"}}), 403);
    EXPECT_EQ(redrive({{"Origin", "http://127.0.0.1"}}), redrive({}));
    EXPECT_EQ(redrive({{"Origin", "https://lab.example"}}), redrive({}));
    EXPECT_NE(redrive({}), 403);
}

// A name of somebody else's page may lead to this machine: then its Origin and Host agree.
TEST(OpenSessionTest, WithoutAuthenticationOnlyTheServersOwnNameIsAnswered) {
    server::ServerConfig config;
    config.no_auth = true;
    config.public_url = "https://lab.example/dives";
    TestServer server(config);
    const auto read = [&](const std::string& host, const std::string& field) {
        RawClient client(server.port());
        client.send("GET /api/v1/dives HTTP/1.1\r\nHost: " + host + "\r\n" + field + "\r\n");
        return client.receive().value_or(RawResponse{}).status;
    };
    // A page of the same origin reads without an Origin; browsers send the other one always.
    const std::string of_browsers = "Accept-Encoding: gzip\r\n";
    EXPECT_EQ(read("evil.example", of_browsers), 403);
    EXPECT_EQ(read("evil.example", "Origin: http://evil.example\r\n"), 403);
    EXPECT_EQ(read("evil.example:8080", of_browsers), 403);
    EXPECT_EQ(read("127.0.0.1.evil.example", of_browsers), 403);
    for (const char* own :
         {"127.0.0.1", "127.0.0.1:8080", "localhost:8080", "[::1]:8080", "lab.example"})
        EXPECT_EQ(read(own, of_browsers), 200) << own;
    EXPECT_EQ(read("a", ""), 200) << "a program is not led by a page";
}

}  // namespace
}  // namespace divemesh
