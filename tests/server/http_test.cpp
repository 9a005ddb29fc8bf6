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

}  // namespace
}  // namespace divemesh
