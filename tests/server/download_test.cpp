#include <gtest/gtest.h>

#include <chrono>
#include <optional>
#include <thread>

#include "api/byte_range.hpp"
#include "schemas/content_hash.hpp"
#include "tests/server/test_server.hpp"

namespace divemesh {
namespace {

class DownloadTest : public testing::Test {
protected:
    RawResponse get(Headers headers = {}) {
        return server.request("GET", path, server.admin(), std::move(headers));
    }

    TestServer server;
    const std::string bytes = random_bytes(700'001);
    const std::string etag = '"' + sha256_hex(bytes) + '"';
    const std::string path =
        "/api/v1/jobs/" + server.make_job("default", "mesh.glb", bytes) + "/artifacts/mesh.glb";
};

TEST_F(DownloadTest, GivesTheWholeFileWithItsHashAsTag) {
    const auto response = get();
    EXPECT_EQ(response.status, 200);
    EXPECT_EQ(response.body, bytes);
    EXPECT_EQ(response.header("etag"), etag);
    EXPECT_EQ(response.header("accept-ranges"), "bytes");
    EXPECT_EQ(response.header("content-type"), "model/gltf-binary");
    EXPECT_EQ(response.header("x-content-type-options"), "nosniff");
    const std::string digest = api::digest_field(sha256_hex(bytes));
    EXPECT_EQ(response.header("repr-digest"), digest);
    EXPECT_EQ(response.header("content-digest"), digest);
}

TEST_F(DownloadTest, GivesTheRangeThatIsAskedFor) {
    const struct {
        const char* range;
        std::size_t offset;
        std::size_t length;
    } cases[] = {{"bytes=0-0", 0, 1},
                 {"bytes=131070-131075", 131070, 6},
                 {"bytes=700000-", 700'000, 1},
                 {"bytes=-11", 699'990, 11},
                 {"bytes=1-9999999", 1, 700'000},
                 {"bytes=1-99999999999999999999", 1, 700'000},
                 {"bytes=-9999999", 0, 700'001}};
    for (const auto& c : cases) {
        const auto response = get({{"Range", c.range}});
        EXPECT_EQ(response.status, 206) << c.range;
        EXPECT_EQ(response.body, bytes.substr(c.offset, c.length)) << c.range;
        EXPECT_EQ(response.header("content-range"),
                  "bytes " + std::to_string(c.offset) + "-" +
                      std::to_string(c.offset + c.length - 1) + "/700001");
    }
}

TEST_F(DownloadTest, SaysHowLongTheFileIsWhenTheRangeLiesOutside) {
    const auto response = get({{"Range", "bytes=700001-"}});
    EXPECT_EQ(response.status, 416);
    EXPECT_EQ(response.header("content-range"), "bytes */700001");
    EXPECT_EQ(response.header("content-type"), "application/problem+json");
}

TEST_F(DownloadTest, AnswersSeveralRangesWithTheWhole) {
    std::string many = "bytes=0-0";
    for (int i = 0; i < 1000; ++i) many += ",5-6";
    for (const std::string& ranges : {many,
                                      std::string("bytes=0-0,5-6"),
                                      std::string("bytes=0-,-1"),
                                      std::string("bytes=,0-0")}) {
        const auto response = get({{"Range", ranges}});  // RFC 9110, 14.2: a server may
        EXPECT_EQ(response.status, 200) << ranges.substr(0, 30);
        EXPECT_EQ(response.body.size(), bytes.size());
        EXPECT_EQ(response.header("content-range"), "");
    }
}

TEST_F(DownloadTest, ResumesOnlyTheSameFile) {
    EXPECT_EQ(get({{"Range", "bytes=5-6"}, {"If-Range", etag}}).status, 206);
    EXPECT_EQ(get({{"Range", "bytes=5-6"}, {"If-Range", "\"other\""}}).status, 200);
    EXPECT_EQ(get({{"Range", "bytes=5-6"}, {"If-Range", "W/" + etag}}).status, 200);
    const char* date = "Sun, 06 Nov 1994 08:49:37 GMT";  // we never gave one
    EXPECT_EQ(get({{"Range", "bytes=5-6"}, {"If-Range", date}}).status, 200);
    EXPECT_EQ(get({{"Range", "bytes=9999999-"}, {"If-Range", "\"other\""}}).status, 200);
    EXPECT_EQ(get({{"If-Range", etag}}).status, 200);
}

TEST_F(DownloadTest, GoesOnOnlyWithTheFileThatTheClientMeans) {
    EXPECT_EQ(get({{"If-Match", etag}}).status, 200);
    EXPECT_EQ(get({{"If-Match", "*"}, {"Range", "bytes=0-0"}}).status, 206);
    EXPECT_EQ(get({{"If-Match", "\"other\""}, {"Range", "bytes=0-0"}}).status, 412);
    EXPECT_EQ(get({{"If-Match", "W/" + etag}}).status, 412);
}

TEST_F(DownloadTest, SendsNothingThatTheClientHas) {
    const auto response = get({{"If-None-Match", "\"other\", " + etag}});
    EXPECT_EQ(response.status, 304);
    EXPECT_TRUE(response.body.empty());
    EXPECT_EQ(response.header("etag"), etag);
    EXPECT_EQ(response.header("cache-control"), "private, no-cache");
}

// RFC 8246: an address that contains the hash of the bytes need not be revalidated.
TEST_F(DownloadTest, AnAddressThatSaysWhichBytesMayBeKept) {
    const auto ask = [&](const std::string& query, const Headers& headers = {}) {
        return server.request("GET", path + query, server.admin(), headers);
    };
    const std::string sha256 = sha256_hex(bytes);
    EXPECT_EQ(ask("").header("cache-control"), "private, no-cache");
    const std::string for_ever = "private, max-age=31536000, immutable";
    const auto whole = ask("?sha256=" + sha256);
    EXPECT_EQ(whole.body, bytes);
    EXPECT_EQ(whole.header("cache-control"), for_ever);
    EXPECT_EQ(ask("?sha256=" + sha256, {{"Range", "bytes=5-6"}}).header("cache-control"), for_ever);
    EXPECT_EQ(ask("?sha256=" + sha256, {{"If-None-Match", etag}}).header("cache-control"),
              for_ever);
    const auto other = ask("?sha256=" + sha256_hex("other"));
    EXPECT_EQ(other.status, 404);
    EXPECT_EQ(other.header("cache-control").find("immutable"), std::string::npos);
    for (const char* wrong : {"?sha256=", "?sha256=abc", "?sha256='OR"})
        EXPECT_EQ(ask(wrong).status, 400) << wrong;
    EXPECT_EQ(server.request("GET", path + "?sha256=" + sha256, "").status, 401);
}

// RFC 9110, 14.2: a Range is of GET alone.
TEST_F(DownloadTest, HeadDescribesTheWholeWithoutSending) {
    const auto response = server.request("HEAD", path, server.admin(), {{"Range", "bytes=0-9"}});
    EXPECT_EQ(response.status, 200);
    EXPECT_EQ(response.header("content-length"), "700001");
    EXPECT_TRUE(response.body.empty());
}

TEST_F(DownloadTest, KeepsTheConnectionForTheNextRequest) {
    RawClient client(server.port());
    const Headers headers = {{"Authorization", "Bearer " + server.admin()}};
    for (int i = 0; i < 3; ++i) EXPECT_EQ(client.request("GET", path, headers).body, bytes);
}

class LargeDownloadTest : public testing::Test {
protected:
    std::string ask() const {
        return request_head("GET",
                            path,
                            {{"Range", "bytes=5-"}, {"Authorization", "Bearer " + server.admin()}},
                            std::nullopt);
    }

    TestServer server;
    const std::string bytes = random_bytes(48 << 20);
    const std::string path =
        "/api/v1/jobs/" + server.make_job("default", "mesh.glb", bytes) + "/artifacts/mesh.glb";
};

TEST_F(LargeDownloadTest, ArrivesWholeThroughASocketThatIsFullMostOfTheTime) {
    RawClient client(server.port(), 16 << 10);
    ASSERT_TRUE(client.send(ask()));
    std::this_thread::sleep_for(std::chrono::milliseconds(300));
    const auto response = client.receive();
    ASSERT_TRUE(response);
    EXPECT_EQ(response->status, 206);
    EXPECT_EQ(sha256_hex(response->body), sha256_hex(bytes.substr(5)));
    EXPECT_EQ(client.request("GET", "/healthz/live").status, 200);  // nothing was left over
}

TEST_F(LargeDownloadTest, AClientThatResetsTheConnectionDoesNoHarm) {
    for (int i = 0; i < 5; ++i) {
        RawClient client(server.port());
        ASSERT_TRUE(client.send(ask()));
        EXPECT_NE(client.read_available(), "");
        client.reset();
    }
    EXPECT_EQ(RawClient(server.port()).request("GET", "/healthz/live").status, 200);
}

TEST(DownloadNamesTest, FindsAnArtifactInAFolderAndNothingElse) {
    TestServer server;
    const std::string artifacts = "/api/v1/jobs/" +
                                  server.make_job("default", "keyframes/000012.jpg", "jpeg") +
                                  "/artifacts/";
    EXPECT_EQ(server.request("GET", artifacts + "keyframes/000012.jpg", server.admin()).body,
              "jpeg");
    EXPECT_EQ(server.request("GET", artifacts + "keyframes%2F000012.jpg", server.admin()).body,
              "jpeg");
    for (const char* name : {"keyframes",
                             "../file",
                             "%2e%2e/file",
                             "..%2f..%2fcatalog.db",
                             "%2e%2e%5cfile",
                             "/etc/passwd",
                             "keyframes/000012.jpg%00",
                             "keyframes//000012.jpg",
                             "file"})
        EXPECT_EQ(server.request("GET", artifacts + name, server.admin()).status, 404) << name;
}

TEST(DownloadNamesTest, HandsPagesOverAsFilesInASandbox) {
    TestServer server;
    const auto response =
        server.request("GET",
                       "/api/v1/jobs/" + server.make_job("default", "page.html", "<script>") +
                           "/artifacts/page.html",
                       server.admin());
    EXPECT_TRUE(response.header("content-disposition").starts_with("attachment"));
    EXPECT_TRUE(response.header("content-security-policy").starts_with("sandbox"));
}

// No artifact but a report is served as a page, whatever its name: what a browser would run is sent
// as an attachment or as plain bytes. A report is in a sandbox, so it is of no origin.
TEST(DownloadNamesTest, NoNameIsServedAsAPage) {
    TestServer server;
    for (const char* name : {"REPORT.HTML",
                             "report.htm",
                             "report.xhtml",
                             "plot.svg",
                             "plot.svgz",
                             "data.xml",
                             "code.js",
                             "page.mhtml",
                             "picture.jpg.html",
                             "picture.html.unknown",
                             "none"}) {
        const auto response = server.request(
            "GET",
            "/api/v1/jobs/" + server.make_job("default", name, "<script>") + "/artifacts/" + name,
            server.admin());
        ASSERT_EQ(response.status, 200) << name;
        EXPECT_EQ(response.header("x-content-type-options"), "nosniff") << name;
        const bool is_file = response.header("content-disposition").starts_with("attachment") &&
                             response.header("content-security-policy").starts_with("sandbox");
        EXPECT_TRUE(is_file || response.header("content-type") == "application/octet-stream")
            << name << ": " << response.header("content-type");
    }
}

TEST(DownloadNamesTest, AReportForCiIsXml) {
    TestServer server;
    const auto response =
        server.request("GET",
                       "/api/v1/jobs/" + server.make_job("default", "junit.xml", "<testsuites/>") +
                           "/artifacts/junit.xml",
                       server.admin());
    EXPECT_EQ(response.header("content-type"), "application/xml");  // RFC 7303, 9.1
}

// The name of an upload is for people: it does not determine the content type, and a dive serves
// no file under it.
TEST(DownloadNamesTest, ANameThatAClientChoseDecidesNoType) {
    TestServer server;
    const auto path =
        create_upload(server.port(), server.admin(), 5, "commit,filename " + base64("evil.html"));
    const auto last =
        RawClient(server.port()).request("PATCH", path, patch_headers(server.admin(), 0), "<svg>");
    const std::string dive = "/api/v1/dives/" + last.header("divemesh-dive");
    EXPECT_EQ(server.request("GET", dive, server.admin()).header("content-type"),
              "application/json");
    EXPECT_EQ(server.request("GET", path, server.admin(), {{"Tus-Resumable", "1.0.0"}})
                  .header("content-type"),
              "application/json");
    EXPECT_EQ(server.request("GET", dive + "/evil.html", server.admin()).status, 404);
    EXPECT_EQ(server.request("GET", dive + "/archive", server.admin()).status, 404);
}

TEST(DownloadNamesTest, AnEmptyArtifactIsWholeAndHasNoRange) {
    TestServer server;
    const std::string path =
        "/api/v1/jobs/" + server.make_job("default", "empty.csv", "") + "/artifacts/empty.csv";
    EXPECT_EQ(server.request("GET", path, server.admin()).status, 200);
    EXPECT_EQ(server.request("GET", path, server.admin(), {{"Range", "bytes=0-"}}).status, 416);
}

}  // namespace
}  // namespace divemesh
