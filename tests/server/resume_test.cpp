#include <gtest/gtest.h>

#include <csignal>
#include <filesystem>

#include "schemas/content_hash.hpp"
#include "tests/server/server_process.hpp"
#include "tests/server/test_server.hpp"

namespace divemesh {
namespace {

using namespace std::chrono_literals;

std::size_t num_files(const std::filesystem::path& folder) {
    std::size_t count = 0;
    for (const auto& entry : std::filesystem::recursive_directory_iterator(folder))
        if (entry.is_regular_file()) ++count;
    return count;
}

// Waits until a HEAD tells an offset of at least `wanted`.
std::int64_t offset_reaches(int port,
                            const std::string& token,
                            const std::string& path,
                            std::int64_t wanted) {
    std::int64_t offset = -1;
    for (int i = 0; i < 500 && offset < wanted; ++i) {
        offset = upload_offset(port, token, path);
        if (offset < wanted) std::this_thread::sleep_for(20ms);
    }
    return offset;
}

TEST(ResumeTest, EverythingThatCameBeforeACutIsKept) {
    TestServer server;
    const auto path = create_upload(server.port(), server.admin(), 1'000'000);
    const std::string bytes = random_bytes(1'000'000);
    {
        RawClient client(server.port());
        client.send(request_head("PATCH", path, patch_headers(server.admin(), 0), 1'000'000));
        client.send(std::string_view(bytes).substr(0, 400'000));
        std::this_thread::sleep_for(200ms);  // a reset takes along what the server has not read
        client.reset();
    }
    const auto offset = offset_reaches(server.port(), server.admin(), path, 400'000);
    ASSERT_EQ(offset, 400'000);
    const auto rest = RawClient(server.port())
                          .request("PATCH",
                                   path,
                                   patch_headers(server.admin(), offset),
                                   std::string_view(bytes).substr(400'000));
    EXPECT_EQ(rest.status, 204);
    const auto id = path.substr(path.rfind('/') + 1);
    const auto dive = server.post_json("/api/v1/dives", server.admin(), {{"upload_id", id}});
    EXPECT_EQ(dive.json()["archive_sha256"], sha256_hex(bytes));
}

TEST(ResumeTest, ANewRequestEndsAnOlderOneThatHangs) {
    TestServer server;
    const auto path = create_upload(server.port(), server.admin(), 1'000'000);
    RawClient half_open(server.port());
    half_open.send(request_head("PATCH", path, patch_headers(server.admin(), 0), 1'000'000));
    half_open.send(std::string(250'000, 'x'));
    std::this_thread::sleep_for(200ms);
    EXPECT_EQ(upload_offset(server.port(), server.admin(), path), 250'000);
    const auto rest =
        RawClient(server.port())
            .request(
                "PATCH", path, patch_headers(server.admin(), 250'000), std::string(750'000, 'y'));
    EXPECT_EQ(rest.status, 204);
    EXPECT_EQ(rest.header("upload-offset"), "1000000");
    half_open.send(std::string(1'000, 'x'));
    EXPECT_EQ(upload_offset(server.port(), server.admin(), path), 1'000'000);
}

// The answer to the last byte is lost: a HEAD request returns the dive too, even right
// after that byte.
TEST(ResumeTest, WhoLostTheLastAnswerIsToldTheDiveByHead) {
    TestServer server;
    const auto bytes = random_bytes(300'000);
    int num_whole = 0;
    for (int i = 0; i < 20; ++i) {
        const std::string own = bytes + std::to_string(i);
        const auto path =
            create_upload(server.port(), server.admin(), std::ssize(own), "commit eWVz");
        RawClient deaf(server.port());
        deaf.send(request_head("PATCH", path, patch_headers(server.admin(), 0), own.size()));
        deaf.send(own);
        std::this_thread::sleep_for(2ms * (i % 10));
        const auto answer =
            RawClient(server.port()).request("HEAD", path, tus_headers(server.admin()));
        ASSERT_EQ(answer.status, 200);
        if (answer.header("upload-offset") != std::to_string(own.size())) continue;
        ++num_whole;
        const auto dive = answer.header("divemesh-dive");
        ASSERT_FALSE(dive.empty()) << i;
        const auto told = server.request("GET", "/api/v1/dives/" + dive, server.admin());
        EXPECT_EQ(told.json()["archive_sha256"], sha256_hex(own));
    }
    EXPECT_GT(num_whole, 0);
}

TEST(ResumeTest, ATerminationEndsAnUploadThatIsUnderWay) {
    TestServer server;
    const auto path = create_upload(server.port(), server.admin(), 1'000'000);
    RawClient sending(server.port());
    sending.send(request_head("PATCH", path, patch_headers(server.admin(), 0), 1'000'000));
    sending.send(std::string(1'000, 'x'));
    const auto gone = RawClient(server.port()).request("DELETE", path, tus_headers(server.admin()));
    EXPECT_EQ(gone.status, 204);
    EXPECT_EQ(upload_offset(server.port(), server.admin(), path), -1);
}

TEST(ResumeTest, ASilentClientIsLeftAndItsBytesAreKept) {
    server::ServerConfig config;
    config.timeouts.body = 300ms;
    TestServer server(config);
    const auto path = create_upload(server.port(), server.admin(), 1'000);
    RawClient client(server.port());
    client.send(request_head("PATCH", path, patch_headers(server.admin(), 0), 1'000));
    client.send(std::string(10, 'x'));
    client.receive();
    EXPECT_TRUE(client.at_end());
    EXPECT_EQ(upload_offset(server.port(), server.admin(), path), 10);
}

TEST(ResumeTest, AClientThatDribblesIsLeftAndItsBytesAreKept) {
    server::ServerConfig config;
    config.min_upload_bytes_per_s = 1'000;
    config.timeouts.rate = 500ms;
    TestServer server(config);
    const auto path = create_upload(server.port(), server.admin(), 100'000);
    RawClient client(server.port());
    client.send(request_head("PATCH", path, patch_headers(server.admin(), 0), 100'000));
    for (int i = 0; i < 40; ++i) {
        client.send("x");
        std::this_thread::sleep_for(20ms);
    }
    EXPECT_EQ(client.receive()->status, 503);
    const auto kept = upload_offset(server.port(), server.admin(), path);
    EXPECT_GT(kept, 0);
    EXPECT_LE(kept, 40);
}

TEST(ResumeTest, AClientAtTheLowestRateIsWaitedFor) {
    server::ServerConfig config;
    config.min_upload_bytes_per_s = 1'000;
    config.timeouts.rate = 300ms;
    TestServer server(config);
    const auto path = create_upload(server.port(), server.admin(), 10'000);
    RawClient client(server.port());
    client.send(request_head("PATCH", path, patch_headers(server.admin(), 0), 10'000));
    for (int i = 0; i < 20; ++i) {
        client.send(std::string(500, 'x'));
        std::this_thread::sleep_for(50ms);
    }
    EXPECT_EQ(client.receive()->status, 204);
}

TEST(ResumeTest, AStoppedServerKeepsWhatCame) {
    const TemporaryFolder data;
    auto first = std::make_unique<ServerProcess>(data.path());
    const std::string token = read_token(data.path());
    const auto path = create_upload(first->port(), token, 1'000'000);
    RawClient client(first->port());
    client.send(request_head("PATCH", path, patch_headers(token, 0), 1'000'000));
    client.send(std::string(123'456, 'x'));
    std::this_thread::sleep_for(300ms);
    EXPECT_EQ(first->end(SIGTERM), 0);
    const ServerProcess second(data.path());
    EXPECT_EQ(upload_offset(second.port(), token, path), 123'456);
}

TEST(ResumeTest, AKilledServerGoesOnWhereTheBytesEnd) {
    const TemporaryFolder data;
    const std::string bytes = random_bytes(3'000'000);
    std::string path;
    std::string token;
    std::int64_t offset = 0;
    for (int life = 0; life < 4; ++life) {
        ServerProcess server(data.path());
        if (life == 0) {
            token = read_token(data.path());
            path = create_upload(server.port(), token, 3'000'000, "commit");
        }
        const std::int64_t found = upload_offset(server.port(), token, path);
        ASSERT_GE(found, offset);
        offset = found;
        RawClient client(server.port());
        client.send(request_head("PATCH",
                                 path,
                                 patch_headers(token, offset),
                                 bytes.size() - static_cast<std::size_t>(offset)));
        client.send(std::string_view(bytes).substr(static_cast<std::size_t>(offset), 700'000));
        std::this_thread::sleep_for(100ms * life);
        server.end(SIGKILL);
    }
    const ServerProcess server(data.path());
    offset = upload_offset(server.port(), token, path);
    const auto last =
        RawClient(server.port())
            .request("PATCH",
                     path,
                     patch_headers(token, offset),
                     std::string_view(bytes).substr(static_cast<std::size_t>(offset)));
    ASSERT_EQ(last.status, 204) << last.body;
    const Headers headers = {{"Authorization", "Bearer " + token}};
    const auto dives = RawClient(server.port()).request("GET", "/api/v1/dives", headers).json();
    ASSERT_EQ(dives["items"].size(), 1U);
    EXPECT_EQ(dives["items"][0]["archive_sha256"], sha256_hex(bytes));
}

TEST(ResumeTest, AServerKilledWithinACheckedChunkKeepsNoneOfIt) {
    const TemporaryFolder data;
    std::string path;
    std::string token;
    {
        ServerProcess server(data.path());
        token = read_token(data.path());
        path = create_upload(server.port(), token, 1'000'000);
        RawClient(server.port())
            .request("PATCH", path, patch_headers(token, 0), std::string(1'000, 'x'));
        RawClient client(server.port());
        Headers headers = patch_headers(token, 1'000);
        headers.emplace_back("Upload-Checksum", "crc32c AAAAAA==");
        client.send(request_head("PATCH", path, headers, 999'000));
        client.send(std::string(500'000, 'y'));
        std::this_thread::sleep_for(200ms);
        server.end(SIGKILL);
    }
    const ServerProcess server(data.path());
    EXPECT_EQ(upload_offset(server.port(), token, path), 1'000);
}

TEST(ResumeTest, AServerKilledWhileItJoinsPartsGoesOn) {
    const TemporaryFolder data;
    const std::string bytes = random_bytes(8'000'000);
    std::string token;
    Headers wanted;
    for (int life = 0; life < 4; ++life) {
        ServerProcess server(data.path());
        if (life == 0) {
            token = read_token(data.path());
            const Headers part = tus_headers(token,
                                             {{"Upload-Length", "8000000"},
                                              {"Upload-Concat", "partial"},
                                              {"Content-Type", "application/offset+octet-stream"}});
            const auto made =
                RawClient(server.port()).request("POST", "/api/v1/uploads", part, bytes);
            const std::string place = made.header("location");
            wanted = tus_headers(token,
                                 {{"Upload-Concat", "final;" + place + " " + place + " " + place}});
        }
        RawClient client(server.port());
        client.send(request_head("POST", "/api/v1/uploads", wanted, 0));
        std::this_thread::sleep_for(10ms * life);
        server.end(SIGKILL);
    }
    const ServerProcess server(data.path());
    const auto whole = RawClient(server.port()).request("POST", "/api/v1/uploads", wanted);
    ASSERT_EQ(whole.status, 201) << whole.body;
    EXPECT_EQ(whole.header("upload-offset"), "24000000");
    const std::string path = whole.header("location");
    const auto made =
        RawClient(server.port())
            .request("POST",
                     "/api/v1/dives",
                     {{"Authorization", "Bearer " + token}, {"Content-Type", "application/json"}},
                     nlohmann::json{{"upload_id", path.substr(path.rfind('/') + 1)}}.dump());
    EXPECT_EQ(made.json()["archive_sha256"], sha256_hex(bytes + bytes + bytes));
    EXPECT_EQ(num_files(data.path() / "blobs" / "staged"), 0U);
}

TEST(ResumeTest, AFullDiskIsToldAndWhatFittedIsKept) {
    const TemporaryFolder data;
    std::string path;
    std::string token;
    const std::string bytes = random_bytes(2'000'000);
    {
        ServerProcess server(data.path(), {"1000000"});
        token = read_token(data.path());
        path = create_upload(server.port(), token, 2'000'000);
        const auto full =
            RawClient(server.port()).request("PATCH", path, patch_headers(token, 0), bytes);
        EXPECT_EQ(full.status, 507) << full.body;
        EXPECT_EQ(full.json()["type"], "urn:divemesh:error:out_of_space");
        EXPECT_EQ(upload_offset(server.port(), token, path), 1'000'000);
        EXPECT_EQ(server.end(SIGTERM), 0);
    }
    const ServerProcess server(data.path());
    const auto rest = RawClient(server.port())
                          .request("PATCH",
                                   path,
                                   patch_headers(token, 1'000'000),
                                   std::string_view(bytes).substr(1'000'000));
    EXPECT_EQ(rest.status, 204);
}

}  // namespace
}  // namespace divemesh
