// The web page as the server sends it: its files, how they are cached, and what browsers let it do.
#include <gtest/gtest.h>

#include "api/routes.hpp"
#include "schemas/error.hpp"
#include "tests/server/test_server.hpp"

namespace divemesh {
namespace {

constexpr std::string_view kIndex = "<!doctype html><title>divemesh</title>";
constexpr std::string_view kScript = "console.log('a script, a script, a script')";
constexpr std::string_view kScriptInGzip = "stands for it in gzip";
constexpr api::PageFile kFiles[] = {
    {"index.html", "text/html; charset=utf-8", "0123456789abcdef0123456789abcdef0123", kIndex, ""},
    {"assets/main-1a2b.js", "text/javascript", "fedcba", kScript, kScriptInGzip},
};

server::ServerConfig with_page() {
    server::ServerConfig config;
    config.page = kFiles;
    config.frame_ancestors = {"https://museum.example", "'self'"};
    return config;
}

class PageTest : public testing::Test {
protected:
    RawResponse get(const std::string& path, const Headers& headers = {}) const {
        return server.request("GET", path, "", headers);
    }
    RawResponse get_script(const std::string& accepted) const {
        return get("/assets/main-1a2b.js", {{"Accept-Encoding", accepted}});
    }

    TestServer server{with_page()};
};

TEST_F(PageTest, EveryAddressOfThePageAnswersWithItWithoutAToken) {
    for (const std::string path : {"/",
                                   "/sign-in",
                                   "/dives",
                                   "/dives/dive_1",
                                   "/jobs/job_1",
                                   "/jobs/job_1/model",
                                   "/sensors",
                                   "/sensors/buoy",
                                   "/share",
                                   "/admin",
                                   "/admin/tokens",
                                   "/embed",
                                   "/dives?site=reef"}) {
        const auto response = get(path);
        EXPECT_EQ(response.status, 200) << path;
        EXPECT_EQ(response.body, kIndex) << path;
        EXPECT_EQ(response.header("content-type"), "text/html; charset=utf-8") << path;
    }
}

TEST_F(PageTest, NoAddressHidesOneOfTheApi) {
    for (const api::Route& route : api::routes())
        EXPECT_EQ(route.kind == api::RouteKind::Page,
                  &route >= api::routes().data() + api::api_routes().size())
            << route.path;
    for (const char* path : {"/api/v1/dive", "/api", "/nothing", "/index.html", "/assets"})
        EXPECT_EQ(get(path).status, 404) << path;
    EXPECT_EQ(server.request("POST", "/dives", "").status, 405);
}

TEST_F(PageTest, BrowsersAskForThePageAgainAndKeepItsFiles) {
    const auto page = get("/");
    EXPECT_EQ(page.header("cache-control"), "no-cache");
    const std::string etag = page.header("etag");
    EXPECT_FALSE(etag.empty());
    const auto again = get("/dives", {{"If-None-Match", etag}});
    EXPECT_EQ(again.status, 304);
    EXPECT_EQ(again.body, "");
    EXPECT_EQ(again.header("etag"), etag);
    EXPECT_FALSE(again.header("content-security-policy").empty());
    const Headers takes_gzip = {{"Accept-Encoding", "gzip"}};
    const std::string gzip_etag = get("/", takes_gzip).header("etag");
    EXPECT_EQ(get("/", {takes_gzip[0], {"If-None-Match", gzip_etag}}).status, 304);
    EXPECT_EQ(get_script("").header("cache-control"), "public, max-age=31536000, immutable");
    EXPECT_EQ(get_script("").header("content-type"), "text/javascript");
}

TEST_F(PageTest, AFileThatIsNotPartOfThePageIsNotFound) {
    for (const char* path : {"/assets/other.js",
                             "/assets/index.html",
                             "/assets/..%2Findex.html",
                             "/assets/%2e%2e/index.html",
                             "/assets/a/b"})
        EXPECT_EQ(get(path).status, 404) << path;
    EXPECT_EQ(get("/assets/other.js").header("content-type"), "application/problem+json");
}

TEST_F(PageTest, HeadAnswersAsGetWithoutTheBytes) {
    for (const std::string path : {"/", "/assets/main-1a2b.js"}) {
        RawClient client(server.port());
        client.send(request_head("HEAD", path, {}, std::nullopt));
        const auto head = client.receive(true);
        ASSERT_TRUE(head) << path;
        EXPECT_EQ(head->status, 200) << path;
        EXPECT_EQ(head->header("content-length"), std::to_string(get(path).body.size())) << path;
        EXPECT_EQ(head->header("etag"), get(path).header("etag")) << path;
    }
}

TEST_F(PageTest, IsSentCompressedToThoseWhoDecodeIt) {
    for (const char* accepted : {"gzip", "br, GZIP;q=0.5", "*", "gzip, deflate, br, zstd"}) {
        const auto response = get_script(accepted);
        EXPECT_EQ(response.header("content-encoding"), "gzip") << accepted;
        EXPECT_EQ(response.body, kScriptInGzip) << accepted;
        EXPECT_EQ(response.header("vary"), "Accept-Encoding") << accepted;
    }
    for (const char* accepted : {"", "br", "gzip;q=0", "gzip; q=0.000", "identity", "x-gzip2"}) {
        const auto response = get_script(accepted);
        EXPECT_EQ(response.header("content-encoding"), "") << accepted;
        EXPECT_EQ(response.body, kScript) << accepted;
        EXPECT_EQ(response.header("vary"), "Accept-Encoding") << accepted;
    }
    EXPECT_NE(get_script("gzip").header("etag"), get_script("").header("etag"));
}

TEST_F(PageTest, OnlyItsOwnScriptsRunAndNoPageFramesIt) {
    for (const char* path : {"/", "/dives/dive_1", "/assets/main-1a2b.js"}) {
        const auto response = get(path);
        const std::string policy = response.header("content-security-policy");
        EXPECT_NE(policy.find("default-src 'none'"), std::string::npos) << path;
        EXPECT_NE(policy.find("script-src 'self' 'wasm-unsafe-eval';"), std::string::npos) << path;
        EXPECT_TRUE(policy.ends_with("frame-ancestors 'none'")) << path;
        EXPECT_EQ(response.header("referrer-policy"), "no-referrer") << path;
        EXPECT_EQ(response.header("x-content-type-options"), "nosniff") << path;
    }
}

TEST_F(PageTest, TheViewerMayBeFramedByPagesThatTheOperatorNames) {
    for (const char* path : {"/embed", "/embed/jobs/job_1"})
        EXPECT_TRUE(get(path)
                        .header("content-security-policy")
                        .ends_with("frame-ancestors https://museum.example 'self'"))
            << path;
    TestServer strict;
    EXPECT_TRUE(strict.request("GET", "/embed", "")
                    .header("content-security-policy")
                    .ends_with("frame-ancestors 'none'"));
}

TEST(PageFreeTest, AServerWithoutThePageSaysSoAndWhereTheApiIs) {
    TestServer server;
    const auto response = server.request("GET", "/", "");
    EXPECT_EQ(response.status, 200);
    EXPECT_EQ(response.header("content-type"), "text/html; charset=utf-8");
    EXPECT_NE(response.body.find("without the web page"), std::string::npos);
    EXPECT_NE(response.body.find("/api/v1"), std::string::npos);
    EXPECT_EQ(server.request("GET", "/assets/main.js", "").status, 404);
    EXPECT_NE(server.request("GET", "/share", "").body.find("src=\"share.js\""), std::string::npos)
        << "sharing links work all the same";
}

TEST(PageFreeTest, RefusesToStartWithFrameAncestorsThatAreNoOrigins) {
    for (const char* wrong :
         {"*", "museum.example", "https://museum.example/x", "https://a;script-src *"}) {
        server::ServerConfig config;
        config.frame_ancestors = {wrong};
        EXPECT_THROW(server::check_config(config), Error) << wrong;
    }
    server::ServerConfig config;
    config.frame_ancestors = {"https://museum.example", "http://127.0.0.1:8000", "'self'"};
    EXPECT_NO_THROW(server::check_config(config));
}

TEST(PageFreeTest, TheFieldsThatDecideAreListedTogether) {
    auto config = with_page();
    config.allowed_origins = {"https://lab.example"};
    TestServer server(config);
    EXPECT_EQ(server.request("GET", "/assets/main-1a2b.js", "").header("vary"),
              "Accept-Encoding, Origin");
}

}  // namespace
}  // namespace divemesh
