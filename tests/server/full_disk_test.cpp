#include <gtest/gtest.h>

#include <fstream>
#include <sys/mount.h>

#include "tests/server/test_server.hpp"

namespace divemesh {
namespace {

namespace fs = std::filesystem;

// A disk of its own: in memory, and small.
class SmallDisk {
public:
    SmallDisk() : mounted_(::mount("tmpfs", folder_.path().c_str(), "tmpfs", 0, "size=32m") == 0) {}
    ~SmallDisk() {
        if (mounted_) ::umount2(folder_.path().c_str(), MNT_DETACH);
    }
    SmallDisk(const SmallDisk&) = delete;
    SmallDisk& operator=(const SmallDisk&) = delete;

    bool mounted() const { return mounted_; }
    fs::path path() const { return folder_.path(); }
    std::uintmax_t free_bytes() const { return fs::space(path()).available; }
    // To the last byte.
    void fill() const {
        std::ofstream filler(path() / "filler", std::ios::binary);
        const std::string page(4096, 'x');
        while (filler.write(page.data(), std::ssize(page)).flush()) {
        }
    }

private:
    TemporaryFolder folder_;
    bool mounted_;
};

// With the disk full to the last byte: what is there is read and deleted, and deleting makes room.
TEST(FullDiskTest, AFullDiskIsStillReadFromAndDeletedFrom) {
    const SmallDisk disk;
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
    ASSERT_EQ(disk.free_bytes(), 0U);

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
    EXPECT_GE(disk.free_bytes(), before + (3U << 20));
    EXPECT_EQ(server.request("GET", dive, token).status, 404);
}

}  // namespace
}  // namespace divemesh
