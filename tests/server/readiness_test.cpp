#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <soci/soci.h>

#include "tests/server/test_server.hpp"

namespace divemesh {
namespace {

using namespace std::chrono_literals;

// It is looked at once a second.
RawResponse ready(const TestServer& server, int expected) {
    RawResponse response;
    for (int i = 0; i < 1000; ++i) {
        response = server.request("GET", "/healthz/ready", "");
        if (response.status == expected) break;
        std::this_thread::sleep_for(10ms);
    }
    EXPECT_EQ(response.status, expected) << response.body;
    return response;
}

std::string detail_of(const RawResponse& response) {
    EXPECT_EQ(response.header("content-type"), "application/problem+json");
    return response.json().value("detail", "");
}

TEST(ReadinessTest, NotReadyWithACatalogOfAnotherVersion) {
    TestServer server;
    const auto set_version = [&](int more) {
        server.catalog().transaction([&](soci::session& session) {
            session << "UPDATE schema_version SET version = version + :more", soci::use(more);
        });
    };
    EXPECT_GT(ready(server, 200).json()["free_bytes"].get<std::int64_t>(), 0);
    set_version(1);
    EXPECT_NE(detail_of(ready(server, 503)).find("catalog: its schema is "), std::string::npos);
    set_version(-1);
    ready(server, 200);
}

TEST(ReadinessTest, NotReadyWithoutAPlaceForBlobs) {
    const TestServer server;
    ready(server, 200);
    const auto uploads = server.data() / "blobs" / "staged" / "uploads";
    ASSERT_TRUE(std::filesystem::is_directory(uploads));
    ASSERT_TRUE(std::filesystem::is_empty(uploads)) << "a probe was left";
    std::filesystem::rename(uploads, server.data() / "away");
    std::ofstream(uploads) << "no folder";
    EXPECT_NE(detail_of(ready(server, 503)).find("blob store: "), std::string::npos);
    std::filesystem::remove(uploads);
    std::filesystem::rename(server.data() / "away", uploads);
    ready(server, 200);
}

TEST(ReadinessTest, NotReadyWithoutTheBlobsOfItsCatalog) {
    const TestServer server;
    ready(server, 200);
    std::filesystem::rename(server.data() / "blobs", server.data() / "away");
    EXPECT_NE(detail_of(ready(server, 503)).find("may not be mounted"), std::string::npos);
    std::filesystem::rename(server.data() / "away", server.data() / "blobs");
    ready(server, 200);
}

TEST(ReadinessTest, NotReadyOnAFullDisk) {
    server::ServerConfig config;
    config.min_free_bytes = std::int64_t{1} << 60;
    const TestServer server(config);
    EXPECT_NE(detail_of(ready(server, 503)).find("disk: "), std::string::npos);
    EXPECT_EQ(server.request("GET", "/healthz/live", "").status, 200);
}

}  // namespace
}  // namespace divemesh
