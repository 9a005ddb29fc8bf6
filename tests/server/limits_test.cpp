#include <gtest/gtest.h>

#include <memory>
#include <thread>
#include <vector>

#include "tests/server/test_server.hpp"

namespace divemesh {
namespace {

using namespace std::chrono_literals;

std::string status_line(RawClient& client) {
    std::string text;
    while (text.find("\r\n") == std::string::npos) {
        const std::string more = client.read_available();
        if (more.empty()) break;
        text += more;
    }
    return text.substr(0, text.find("\r\n"));
}

TEST(LimitsTest, RefusesAHeaderThatIsTooLarge) {
    TestServer server;
    RawClient client(server.port());
    client.send("GET /healthz/live HTTP/1.1\r\nX: " + std::string(40'000, 'x') + "\r\n\r\n");
    EXPECT_TRUE(status_line(client).starts_with("HTTP/1.1 431"));
}

TEST(LimitsTest, RefusesABodyThatIsTooLargeBeforeItIsSent) {
    TestServer server;
    RawClient client(server.port());
    client.send(request_head(
        "POST",
        "/api/v1/dives",
        {{"Authorization", "Bearer " + server.admin()}, {"Content-Type", "application/json"}},
        std::size_t{1} << 40));
    EXPECT_EQ(client.receive()->status, 413);
}

TEST(LimitsTest, RefusesAnEndlessChunkedBody) {
    TestServer server;
    RawClient client(server.port());
    client.send(request_head("POST",
                             "/api/v1/dives",
                             {{"Authorization", "Bearer " + server.admin()},
                              {"Content-Type", "application/json"},
                              {"Transfer-Encoding", "chunked"}},
                             std::nullopt));
    for (int i = 0; i < 40 && client.send("10000\r\n" + std::string(0x10000, ' ') + "\r\n"); ++i) {
    }
    const auto response = client.receive();
    ASSERT_TRUE(response);
    EXPECT_EQ(response->status, 413);
}

TEST(LimitsTest, RefusesWhatIsNotHttpOrMeansTwoThings) {
    TestServer server;
    for (const char* bytes :
         {"nonsense\r\n\r\n",
          "GET / HTTP/9.9\r\n\r\n",
          "GET /healthz/live HTTP/1.1\r\nContent-Length: 1\r\nContent-Length: 2\r\n\r\n",
          "GET /healthz/live HTTP/1.1\r\nContent-Length: x\r\n\r\n",
          "GET /healthz/live HTTP/1.1\r\nBad Name: x\r\n\r\n",
          "GET /healthz/live HTTP/1.1\r\nContent-Length : 1\r\n\r\nx",
          "GET /healthz/live HTTP/1.1\r\nHost: a\r\nHost: b\r\n\r\n",
          "GET /healthz/live HTTP/1.1\nHost: a\n\n",
          "POST /api/v1/dives HTTP/1.1\r\nTransfer-Encoding: chunked\r\n\r\nxyz\r\n\r\n",
          "POST /api/v1/dives HTTP/1.1\r\nContent-Length: 5\r\n"
          "Transfer-Encoding: chunked\r\n\r\n0\r\n\r\n",
          "\x16\x03\x01\x02"}) {
        RawClient client(server.port());
        client.send(bytes);
        client.send("\r\n\r\n");
        const std::string line = status_line(client);
        EXPECT_TRUE(line.empty() || line.starts_with("HTTP/1.1 4")) << bytes << " -> " << line;
    }
    EXPECT_EQ(server.request("GET", "/healthz/live", "").status, 200);
}

TEST(LimitsTest, LeavesAClientThatNeverFinishesItsHeader) {
    server::ServerConfig config;
    config.timeouts.header = 300ms;
    TestServer server(config);
    RawClient client(server.port());
    client.send("GET /healthz/live HTTP/1.1\r\nX: ");
    EXPECT_TRUE(client.at_end());
}

TEST(LimitsTest, LeavesAClientThatTakesNoAnswer) {
    server::ServerConfig config;
    config.timeouts.write = 300ms;
    TestServer server(config);
    const std::string path = "/api/v1/jobs/" +
                             server.make_job("default", "mesh.glb", random_bytes(20'000'000)) +
                             "/artifacts/mesh.glb";
    RawClient client(server.port(), 4096);
    client.send(
        request_head("GET", path, {{"Authorization", "Bearer " + server.admin()}}, std::nullopt));
    std::this_thread::sleep_for(1s);
    std::size_t received = 0;
    for (std::string more = client.read_available(); !more.empty(); more = client.read_available())
        received += more.size();
    EXPECT_LT(received, 20'000'000U);
}

// Headers of a proxy have no effect.
TEST(LimitsTest, HeadersOfProxiesChangeNothing) {
    server::ServerConfig config;
    config.max_failed_logins_per_s = 0.01;  // one at once
    TestServer server(config);
    const auto guess = [&](const std::string& address) {
        return server.request("GET", "/api/v1/dives", "dm_guess", {{"X-Forwarded-For", address}})
            .status;
    };
    EXPECT_EQ(guess("10.0.0.1"), 401);
    EXPECT_EQ(guess("10.0.0.2"), 429);
    const auto made = server.request("POST",
                                     "/api/v1/uploads",
                                     server.admin(),
                                     {{"Tus-Resumable", "1.0.0"},
                                      {"Upload-Length", "1"},
                                      {"X-Forwarded-Host", "evil.example"},
                                      {"Forwarded", "host=evil.example"}});
    EXPECT_EQ(made.status, 201);
    EXPECT_EQ(made.header("location").find("evil"), std::string::npos);
}

TEST(LimitsTest, AnswersRequestsThatAreSentInOneGo) {
    TestServer server;
    RawClient client(server.port());
    const std::string request = request_head("GET", "/healthz/live", {}, std::nullopt);
    client.send(request + request + request);
    for (int i = 0; i < 3; ++i) EXPECT_EQ(client.receive()->status, 200);
}

// Sends the head of an upload's body and a part of it, so that its connection is at work.
// One connection, whose request the server has begun to answer.
std::unique_ptr<RawClient> begun_upload(const TestServer& server) {
    auto client = std::make_unique<RawClient>(server.port());
    const auto path = create_upload(*client, server.admin(), 1'000);
    Headers headers = patch_headers(server.admin(), 0);
    headers.emplace_back("Expect", "100-continue");
    client->send(request_head("PATCH", path, headers, 1'000));
    EXPECT_EQ(status_line(*client), "HTTP/1.1 100 Continue");
    client->send("hello");
    return client;
}

TEST(LimitsTest, TakesNoMoreConnectionsThanItMay) {
    server::ServerConfig config;
    config.max_connections = 2;
    TestServer server(config);
    const auto first = begun_upload(server);
    const auto second = begun_upload(server);
    RawClient third(server.port());
    const auto refused = third.receive();
    ASSERT_TRUE(refused);
    EXPECT_EQ(refused->status, 503);
    EXPECT_EQ(refused->header("retry-after"), "5");
    EXPECT_EQ(refused->header("content-type"), "application/problem+json");
    EXPECT_EQ(refused->json()["status"], 503);
    EXPECT_TRUE(third.at_end());
    for (const auto& client : {first.get(), second.get()}) {
        client->send(std::string(995, 'x'));
        EXPECT_EQ(client->receive()->status, 204);
    }
}

TEST(LimitsTest, SilentConnectionsLockNobodyOut) {
    server::ServerConfig config;
    config.max_connections = 20;
    TestServer server(config);
    const auto upload = begun_upload(server);
    std::vector<std::unique_ptr<RawClient>> silent;
    for (int i = 0; i < 60; ++i) {
        silent.push_back(std::make_unique<RawClient>(server.port()));
        if (i % 2 == 0) silent.back()->send("GET /healthz/live HTTP/1.1\r\nX: ");
    }
    EXPECT_EQ(server.request("GET", "/api/v1/dives", server.admin()).status, 200);
    EXPECT_EQ(server.request("GET", "/healthz/live", "").status, 200);
    upload->send(std::string(995, 'x'));
    EXPECT_EQ(upload->receive()->status, 204);
    EXPECT_TRUE(silent.front()->at_end()) << "the first one has been silent for longest";
}

TEST(LimitsTest, StopsDespiteIdleClientsAndUnfinishedRequests) {
    server::ServerConfig config;
    config.timeouts.stop = 2s;
    TestServer server(config);
    RawClient idle(server.port());
    RawClient half(server.port());
    half.send("GET /healthz/live HTTP/1.1\r\n");
    RawClient sending(server.port());
    const auto path = create_upload(server.port(), server.admin(), 1'000);
    sending.send(request_head("PATCH", path, patch_headers(server.admin(), 0), 1'000));
    sending.send("hello");
    std::this_thread::sleep_for(100ms);
    const auto asked = std::chrono::steady_clock::now();
    server.stop();
    EXPECT_LT(std::chrono::steady_clock::now() - asked, 10s) << "what the requirement allows";
    EXPECT_TRUE(idle.at_end());
    EXPECT_TRUE(half.at_end());
}

}  // namespace
}  // namespace divemesh
