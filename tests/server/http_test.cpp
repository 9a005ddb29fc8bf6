#include <gtest/gtest.h>

#include "tests/server/test_server.hpp"

// What RFC 9112 and RFC 9110 ask of a server, byte by byte.
namespace divemesh {
namespace {

class HttpTest : public testing::Test {
protected:
    // Returns the status of the response to these bytes; 0 if the connection ends without one.
    int status_of(const std::string& bytes) {
        RawClient client(server_.port());
        client.send(bytes);
        const auto response = client.receive();
        return response ? response->status : 0;
    }
    // Expects that these bytes get one response with this status, and that the connection ends.
    void expect_last(const std::string& bytes, int status) {
        RawClient client(server_.port());
        client.send(bytes);
        const auto response = client.receive();
        ASSERT_TRUE(response) << bytes;
        EXPECT_EQ(response->status, status) << bytes << response->body;
        EXPECT_EQ(response->header("content-type"), "application/problem+json") << bytes;
        EXPECT_EQ(response->header("connection"), "close") << bytes;
        EXPECT_NE(response->header("x-request-id"), "") << bytes;
        EXPECT_TRUE(client.at_end()) << bytes;
    }

    TestServer server_;
};

constexpr const char* kSmuggled = "0\r\n\r\nGET /healthz/live HTTP/1.1\r\nHost: a\r\n\r\n";

TEST_F(HttpTest, UnknownTransferCodingsAre501AndSmuggleNoRequest) {
    for (const char* coding : {"xchunked",
                               "gzip",
                               "identity",
                               "gzip, chunked",
                               "chunked, gzip",
                               "\"chunked\"",
                               "gzip\r\nTransfer-Encoding: chunked"})
        expect_last(std::string("POST /healthz/live HTTP/1.1\r\nHost: a\r\nTransfer-Encoding: ") +
                        coding + "\r\n\r\n" + kSmuggled,
                    501);
}

TEST_F(HttpTest, ChunkedTwiceOrWithParametersIs400AndSmugglesNoRequest) {
    for (const char* coding :
         {"chunked, chunked", "chunked,,chunked", "chunked;q=1", "", ",", "chunked ,\tchunked"})
        expect_last(std::string("POST /healthz/live HTTP/1.1\r\nHost: a\r\nTransfer-Encoding: ") +
                        coding + "\r\n\r\n" + kSmuggled,
                    400);
}

TEST_F(HttpTest, TransferEncodingGoesNeitherWithContentLengthNorWithHttp10) {
    const std::string head = "POST /healthz/live HTTP/1.1\r\nHost: a\r\n";
    EXPECT_EQ(status_of(head + "Content-Length: 5\r\nTransfer-Encoding: chunked\r\n\r\n0\r\n\r\n"),
              400);
    EXPECT_EQ(status_of(head + "Transfer-Encoding: chunked\r\nContent-Length: 5\r\n\r\n0\r\n\r\n"),
              400);
    expect_last(head + "Transfer-Encoding: xchunked\r\nContent-Length: 0\r\n\r\n" + kSmuggled, 400);
    expect_last(std::string("POST /healthz/live HTTP/1.0\r\nConnection: keep-alive\r\n"
                            "Transfer-Encoding: chunked\r\n\r\n") +
                    kSmuggled,
                400);
}

TEST_F(HttpTest, TakesChunkedInAnyCaseAndEmptyListElements) {
    for (const char* coding : {"chunked", "CHUNKED", ", chunked", "chunked,"}) {
        RawClient client(server_.port());
        client.send("POST /api/v1/dives HTTP/1.1\r\nHost: a\r\nAuthorization: Bearer " +
                    server_.admin() + "\r\nContent-Type: application/json\r\nTransfer-Encoding: " +
                    coding + "\r\n\r\n2\r\n{}\r\n" + kSmuggled);
        EXPECT_EQ(client.receive()->status, 400) << "upload_id is missing";
        EXPECT_EQ(client.receive()->status, 200) << "the next request, which is not smuggled";
    }
}

std::string get(const std::string& target, const std::string& fields) {
    return "GET " + target + " HTTP/1.1\r\n" + fields + "\r\n";
}

TEST_F(HttpTest, TakesTheAbsoluteFormOfATarget) {
    const std::string token = "Authorization: Bearer " + server_.admin() + "\r\n";
    EXPECT_EQ(status_of(get("http://dives.example/healthz/live", "Host: a\r\n")), 200);
    EXPECT_EQ(status_of(get("HTTPS://[::1]:8080/healthz/live", "Host: a\r\n")), 200);
    EXPECT_EQ(status_of(get("http://a/api/v1/dives?limit=1", "Host: a\r\n" + token)), 200);
    EXPECT_EQ(status_of(get("http://a/api/v1/dives?limit=0", "Host: a\r\n" + token)), 400);
    EXPECT_EQ(status_of(get("http://a", "Host: a\r\n")), 200) << "the path is /";
    for (const char* target : {"http:///healthz/live",
                               "http://me@a/healthz/live",
                               "http://a:x/healthz/live",
                               "ftp://a/healthz/live",
                               "a/healthz/live"})
        EXPECT_EQ(status_of(get(target, "Host: a\r\n")), 400) << target;
}

TEST_F(HttpTest, WantsExactlyOneValidHost) {
    for (const char* fields : {"Host: a\r\n",
                               "Host: a.example:8080\r\n",
                               "Host: 127.0.0.1:\r\n",
                               "Host: [::1]:80\r\n",
                               "Host: a_b%20c\r\n"})
        EXPECT_EQ(status_of(get("/healthz/live", fields)), 200) << fields;
    for (const char* fields : {"",
                               "Host: a\r\nHost: a\r\n",
                               "Host: a\r\nhost: b\r\n",
                               "Host: a, b\r\n",
                               "Host:\r\n",
                               "Host: a b\r\n",
                               "Host: a/b\r\n",
                               "Host: me@a\r\n",
                               "Host: a:b\r\n",
                               "Host: a:65536\r\n",
                               "Host: [::1\r\n",
                               "Host: ::1\r\n",
                               "Host: [a]\r\n",
                               "Host: a%2\r\n",
                               "Host: http://a\r\n"})
        expect_last(get("/healthz/live", fields), 400);
    EXPECT_EQ(status_of("GET /healthz/live HTTP/1.0\r\n\r\n"), 200) << "HTTP/1.0 has no Host";
}

TEST_F(HttpTest, IgnoresOneEmptyLineBeforeARequest) {
    const std::string request = get("/healthz/live", "Host: a\r\n");
    EXPECT_EQ(status_of("\r\n" + request), 200);
    EXPECT_EQ(status_of("\r\n\r\n" + request), 400);
    EXPECT_EQ(status_of("\n" + request), 400);
    RawClient client(server_.port());
    client.send(request + "\r\n" + request + "\r");
    EXPECT_EQ(client.receive()->status, 200);
    EXPECT_EQ(client.receive()->status, 200);
    client.send("\n" + request);
    EXPECT_EQ(client.receive()->status, 200);
}

constexpr const char* kBrokenChunks[] = {"zz\r\n{}\r\n0\r\n\r\n",
                                         "-2\r\n{}\r\n0\r\n\r\n",
                                         "0x2\r\n{}\r\n0\r\n\r\n",
                                         "\r\n{}\r\n0\r\n\r\n",
                                         "2\r\n{}XX0\r\n\r\n",
                                         "2\r\n{}\n0\r\n\r\n",
                                         "1\r\n{}\r\n0\r\n\r\n",
                                         "2 2\r\n{}\r\n0\r\n\r\n",
                                         "10000000000000000\r\n{}\r\n0\r\n\r\n"};

TEST_F(HttpTest, BrokenChunksOfABodyAre400) {
    for (const char* chunks : kBrokenChunks)
        expect_last(
            "POST /api/v1/dives HTTP/1.1\r\nHost: a\r\nAuthorization: Bearer " + server_.admin() +
                "\r\nContent-Type: application/json\r\nTransfer-Encoding: chunked\r\n\r\n" + chunks,
            400);
}

TEST_F(HttpTest, BrokenChunksOfAnUploadAre400) {
    for (const char* chunks : kBrokenChunks) {
        const auto path = create_upload(server_.port(), server_.admin(), 100);
        Headers headers = patch_headers(server_.admin(), 0);
        headers.emplace_back("Transfer-Encoding", "chunked");
        expect_last(request_head("PATCH", path, headers, std::nullopt) + chunks, 400);
    }
}

TEST_F(HttpTest, AContentLengthIsOneNumber) {
    const std::string head = "POST /api/v1/dives HTTP/1.1\r\nHost: a\r\nAuthorization: Bearer " +
                             server_.admin() + "\r\nContent-Type: application/json\r\n";
    for (const char* fields : {"Content-Length: 9223372036854775808\r\n",
                               "Content-Length: 18446744073709551615\r\n",
                               "Content-Length: 18446744073709551618\r\n",
                               "Content-Length: 99999999999999999999999\r\n",
                               "Content-Length: 2, 3\r\n",
                               "Content-Length: 2\r\nContent-Length: 3\r\n",
                               "Content-Length: -2\r\n",
                               "Content-Length: +2\r\n",
                               "Content-Length: 2x\r\n",
                               "Content-Length: 0x2\r\n",
                               "Content-Length:\r\n"})
        expect_last(head + fields + "\r\n{}", 400);
    expect_last(head + "Content-Length: 9223372036854775807\r\n\r\n{}", 413);
    expect_last(head + "Content-Length: 1048577\r\n\r\n{}", 413);
    EXPECT_EQ(status_of(head + "Content-Length: 2, 2\r\n\r\n{}"), 400) << "upload_id is missing";
}

TEST_F(HttpTest, ABodyWithAContentCodingIs415AndLearnsWhichAreKnown) {
    const Headers json = {{"Content-Type", "application/json"}};
    for (const char* coding : {"gzip", "GZIP", "br", "gzip, identity", "identity, gzip"}) {
        Headers headers = json;
        headers.emplace_back("Content-Encoding", coding);
        const auto response =
            server_.request("POST", "/api/v1/dives", server_.admin(), headers, "{}");
        EXPECT_EQ(response.status, 415) << coding;
        EXPECT_EQ(response.header("accept-encoding"), "identity") << coding;
    }
    for (const char* coding : {"identity", "Identity", ""}) {
        Headers headers = json;
        headers.emplace_back("Content-Encoding", coding);
        const auto response =
            server_.request("POST", "/api/v1/dives", server_.admin(), headers, "{}");
        EXPECT_EQ(response.status, 400) << coding << ": upload_id is missing";
    }
    const auto path = create_upload(server_.port(), server_.admin(), 100);
    Headers headers = patch_headers(server_.admin(), 0);
    headers.emplace_back("Content-Encoding", "gzip");
    const auto response = RawClient(server_.port()).request("PATCH", path, headers, "hello");
    EXPECT_EQ(response.status, 415);
    EXPECT_EQ(response.header("accept-encoding"), "identity");
    EXPECT_EQ(upload_offset(server_.port(), server_.admin(), path), 0);
}

TEST_F(HttpTest, ComparesMediaTypesWithoutCaseAndParameters) {
    for (const char* type : {"application/json",
                             "Application/JSON",
                             "application/json ; charset=utf-8",
                             "application/merge-patch+json",
                             "Application/Merge-Patch+JSON; charset=utf-8"}) {
        const Headers headers = {{"Content-Type", type}};
        const auto response = server_.request(
            "PATCH", "/api/v1/queue", server_.admin(), headers, R"({"paused": false})");
        EXPECT_EQ(response.status, 200) << type << response.body;
    }
    for (const char* type : {"application/jsonx", "text/plain; application/json", "json", ""}) {
        const Headers headers = {{"Content-Type", type}};
        const auto response = server_.request(
            "PATCH", "/api/v1/queue", server_.admin(), headers, R"({"paused": false})");
        EXPECT_EQ(response.status, 415) << type;
    }
    const Headers merge_patch = {{"Content-Type", "application/merge-patch+json"}};
    EXPECT_EQ(server_.request("POST", "/api/v1/dives", server_.admin(), merge_patch, "{}").status,
              415)
        << "it is a document for PATCH alone";
}

TEST_F(HttpTest, RefusesUnknownQueryParametersAndNamesTheNearest) {
    const auto response =
        server_.request("GET", "/api/v1/dives?limit=1&stat=ready", server_.admin());
    EXPECT_EQ(response.status, 400);
    EXPECT_EQ(response.json()["detail"], "unknown parameter stat; did you mean state?");
    EXPECT_EQ(response.json()["errors"][0]["parameter"], "stat");
    const auto none = server_.request("GET", "/healthz/live?verbose=1", "");
    EXPECT_EQ(none.status, 400);
    EXPECT_EQ(none.json()["detail"], "unknown parameter verbose; this address takes none");
    const auto far = server_.request("GET", "/api/v1/queue?xyzzy", server_.admin());
    EXPECT_EQ(far.status, 400);
    EXPECT_EQ(far.json()["detail"], "unknown parameter xyzzy; this address takes fields, project");
    const auto both = server_.request("GET", "/api/v1/dives?tags=a&sites=b", server_.admin());
    EXPECT_EQ(both.json()["errors"].size(), 2U);
    EXPECT_EQ(server_.request("GET", "/api/v1/dives?stat=ready", "").status, 401);
}

}  // namespace
}  // namespace divemesh
