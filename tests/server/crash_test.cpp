// SIGKILL at every fault point that a server passes between the last bytes of an upload and the
// answer that names its dive. The next server, with or without a client that asks, has the dive.
#include <gtest/gtest.h>

#include <chrono>
#include <csignal>
#include <filesystem>
#include <functional>
#include <set>
#include <thread>

#include "schemas/content_hash.hpp"
#include "tests/server/server_process.hpp"
#include "tests/server/test_server.hpp"

namespace divemesh {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;

class CrashTest : public testing::Test {
protected:
    using Verify = std::function<void(const ServerProcess&, bool is_whole)>;

    void SetUp() override {
        ServerProcess server(prepared_);
        token_ = read_token(prepared_);
        path_ = create_upload(server.port(),
                              token_,
                              static_cast<std::int64_t>(bytes_.size()),
                              "commit,job " + base64("standard"));
        ASSERT_EQ(server.end(SIGTERM), 0);
    }

    // Sends the bytes to servers over copies of one folder, each killed one fault point later, and
    // has `verify` look at the server after. Returns how many were killed.
    int kill_everywhere(const Verify& verify) {
        for (int number = 1;; ++number) {
            SCOPED_TRACE("killed at " + std::to_string(number));
            const fs::path place = folder_ / std::to_string(number);
            fs::copy(prepared_, place, fs::copy_options::recursive);
            const bool killed = is_killed_at(number, place);
            if (killed) {
                const bool is_whole = has_all_bytes(place);
                const ServerProcess next(place);
                verify(next, is_whole);
            }
            if (!killed || HasFailure()) return number - 1;
            fs::remove_all(place);
        }
    }

    bool is_killed_at(int number, const fs::path& place) {
        ServerProcess server(place, {"0", std::to_string(number)});
        RawClient client(server.port());
        server.send(SIGUSR1);
        client.send(request_head("PATCH", path_, patch_headers(token_, 0), bytes_.size()));
        client.send(bytes_);
        const auto answer = client.receive();
        if (!answer) {
            EXPECT_EQ(server.end(SIGCONT), 128 + SIGKILL);
            return true;
        }
        EXPECT_EQ(answer->status, 204) << answer->body;
        return false;
    }

    bool has_all_bytes(const fs::path& place) const {
        for (const auto& entry : fs::recursive_directory_iterator(place / "blobs"))
            if (entry.is_regular_file() && entry.file_size() == bytes_.size()) return true;
        return false;
    }

    nlohmann::json list(int port, const std::string& what) const {
        const Headers headers = {{"Authorization", "Bearer " + token_}};
        return RawClient(port).request("GET", "/api/v1/" + what, headers).json()["items"];
    }

    void expect_the_dive(int port) const {
        nlohmann::json dives;
        for (int i = 0; i < 1000 && dives.empty(); ++i) {
            dives = list(port, "dives");
            if (dives.empty()) std::this_thread::sleep_for(10ms);
        }
        ASSERT_EQ(dives.size(), 1U);
        EXPECT_EQ(dives[0]["archive_sha256"], sha256_hex(bytes_));
        std::multiset<std::string> kinds;
        for (const auto& job : list(port, "jobs")) kinds.insert(job["kind"]);
        EXPECT_EQ(kinds, (std::multiset<std::string>{"intake", "reconstruct"}));
    }

    const TemporaryFolder folder_;
    const fs::path prepared_ = folder_ / "prepared";
    const std::string bytes_ = random_bytes(300'000);
    std::string token_;
    std::string path_;
};

TEST_F(CrashTest, AClientThatGoesOnGetsItsDive) {
    const int num_points = kill_everywhere([&](const ServerProcess& server, bool) {
        const auto offset = upload_offset(server.port(), token_, path_);
        ASSERT_GE(offset, 0);
        if (offset < static_cast<std::int64_t>(bytes_.size())) {
            const auto rest =
                RawClient(server.port())
                    .request("PATCH",
                             path_,
                             patch_headers(token_, offset),
                             std::string_view(bytes_).substr(static_cast<std::size_t>(offset)));
            ASSERT_EQ(rest.status, 204) << rest.body;
        }
        expect_the_dive(server.port());
    });
    EXPECT_GT(num_points, 30);
}

TEST_F(CrashTest, BytesThatAllCameBecomeTheirDiveThoughNobodyAsks) {
    int num_whole = 0;
    kill_everywhere([&](const ServerProcess& server, bool is_whole) {
        if (!is_whole) return;
        ++num_whole;
        expect_the_dive(server.port());
    });
    EXPECT_GT(num_whole, 10);  // how many there are depends on who writes in between
}

}  // namespace
}  // namespace divemesh
