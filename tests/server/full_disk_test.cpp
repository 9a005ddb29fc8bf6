#include <gtest/gtest.h>

#include "tests/server/test_server.hpp"
#include "tests/small_disk.hpp"

namespace divemesh {
namespace {

namespace fs = std::filesystem;

// With the disk full to the last byte: what is there is read and deleted, and deleting makes room.
TEST(FullDiskTest, AFullDiskIsStillReadFromAndDeletedFrom) {
    const SmallDisk disk(32);
    if (!disk.mounted()) GTEST_SKIP() << "needs the right to mount a tmpfs";
    server::ServerConfig config;
    config.data = disk.path();
    config.min_free_bytes = 1 << 20;
    TestServer server(config);
    const std::string token = server.make_token("default", {"dives:read", "dives:write"});
    const std::string upload = create_upload(server.port(), server.admin(), 4 << 20);
    const auto sent = server.request(
        "PATCH", upload, "", patch_headers(server.admin(), 0), random_bytes(4 << 20));
    ASSERT_EQ(sent.status, 204) << sent.body;
    const auto made = server.post_json(
        "/api/v1/dives", server.admin(), {{"upload_id", upload.substr(upload.rfind('/') + 1)}});
    ASSERT_EQ(made.status, 201) << made.body;
    const std::string dive = "/api/v1/dives/" + made.json()["id"].get<std::string>();
    const std::string other = create_upload(server.port(), server.admin(), 100);
    for (int i = 0; i < 500 && !fs::exists(disk.path() / "reserve"); ++i)
        std::this_thread::sleep_for(std::chrono::milliseconds(10));
    ASSERT_TRUE(fs::exists(disk.path() / "reserve"));
    disk.fill();
    ASSERT_EQ(disk.free_bytes(), 0);

    EXPECT_EQ(server.request("GET", dive, token).status, 200);
    EXPECT_EQ(server.request("GET", "/healthz/ready", "").status, 503);
    EXPECT_EQ(
        server
            .request("POST", "/api/v1/uploads", "", tus_headers(token, {{"Upload-Length", "100"}}))
            .status,
        507);
    EXPECT_EQ(server.request("DELETE", other, "", tus_headers(token)).status, 204);
    const Headers any = {{"If-Match", "*"}};
    EXPECT_EQ(server.request("DELETE", dive + "?purge=true", token, any).status, 403);
    const auto deleted = server.request("DELETE", dive, token, any);
    EXPECT_EQ(deleted.status, 200) << deleted.body;
    EXPECT_GT(deleted.json()["expires_at_ms"], deleted.json()["deleted_at_ms"]);
    const auto before = disk.free_bytes();
    EXPECT_EQ(server.request("DELETE", dive + "?purge=true", server.admin(), any).status, 200);
    EXPECT_GE(disk.free_bytes(), before + (3 << 20));
    EXPECT_EQ(server.request("GET", dive, token).status, 404);
}

// What can be computed again goes before an upload, its bytes or a job are refused.
TEST(FullDiskTest, GivesUpWhatCanBeComputedAgainBeforeItRefuses) {
    const SmallDisk disk(64);
    if (!disk.mounted()) GTEST_SKIP() << "needs the right to mount a tmpfs";
    const fs::path cache = disk.path() / "cache-entry";
    server::ServerConfig config;
    config.data = disk.path();
    config.min_free_bytes = 20 << 20;
    config.make_room = [&](std::int64_t wanted_free_bytes) {
        if (disk.free_bytes() < wanted_free_bytes) fs::remove(cache);
    };
    TestServer server(config);
    const std::string admin = server.admin();
    const std::string dive = server.make_dive("default", std::string(64, 'a'));
    for (int i = 0; i < 500 && !fs::exists(disk.path() / "reserve"); ++i)
        std::this_thread::sleep_for(std::chrono::milliseconds(10));
    const auto fill_cache = [&](int left_mib) {
        disk.write(cache, static_cast<int>(disk.free_bytes() >> 20) - left_mib);
    };

    fill_cache(22);  // more than --min-free, but not with the upload
    const std::string upload = create_upload(server.port(), admin, 4 << 20);
    EXPECT_FALSE(fs::exists(cache));
    fill_cache(19);
    const auto sent =
        server.request("PATCH", upload, "", patch_headers(admin, 0), random_bytes(4 << 20));
    EXPECT_EQ(sent.status, 204) << sent.body;
    EXPECT_FALSE(fs::exists(cache));
    fill_cache(19);
    const auto job =
        server.post_json("/api/v1/dives/" + dive + "/jobs", admin, nlohmann::json::object());
    EXPECT_EQ(job.status, 201) << job.body;
    EXPECT_FALSE(fs::exists(cache));
    fill_cache(19);
    EXPECT_EQ(server.request("GET", "/healthz/ready", "").status, 200);
    EXPECT_FALSE(fs::exists(cache));
}

}  // namespace
}  // namespace divemesh
