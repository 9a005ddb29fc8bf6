// Reads by key are answered on the I/O thread, even while the pool is busy.
#include <future>
#include <soci/soci.h>

#include "tests/server/tus_fixture.hpp"

namespace divemesh {
namespace {

using namespace std::chrono_literals;

server::ServerConfig with_one_thread() {
    server::ServerConfig config;
    config.num_blocking_threads = 1;
    return config;
}

class ReadNonblockingTest : public TusTest {
protected:
    ReadNonblockingTest() : TusTest(with_one_thread()) {}

    // The status of the answer; nothing when it takes long.
    static std::optional<int> status_within(std::future<RawResponse>& answer,
                                            std::chrono::milliseconds timeout) {
        if (answer.wait_for(timeout) != std::future_status::ready) return std::nullopt;
        return answer.get().status;
    }
    std::future<RawResponse> ask(const std::string& method, const std::string& target) {
        return std::async(std::launch::async, [this, method, target] {
            return server.request(method, target, token, {{"If-Match", "*"}});
        });
    }
};

TEST_F(ReadNonblockingTest, AJobADiveAndAnUploadAreReadWhileThePoolWaitsForTheDisk) {
    const auto job = "/api/v1/jobs/" + server.make_job("default", "mesh.glb", "glTF");
    const auto dive = "/api/v1/dives/" + server.make_dive("default", sha256_hex("1"));
    const auto upload = create_upload(server.port(), token, 10);
    server.request("GET", job, token);  // that the token was used is written once a minute
    std::promise<void> done;
    std::promise<void> held;
    const auto writer = std::async(std::launch::async, [&] {
        server.catalog().transaction([&](soci::session&) {
            held.set_value();
            done.get_future().wait();
        });
    });
    held.get_future().wait();
    auto stuck = ask("DELETE", dive);  // needs the write lock, and keeps the pool's only thread
    EXPECT_FALSE(status_within(stuck, 200ms));
    auto list = ask("GET", "/api/v1/jobs");
    for (int i = 0; i < 3; ++i) {  // for longer than a token is believed unseen
        for (const auto& path : {job, dive, upload, std::string("/healthz/live")}) {
            auto read = ask("GET", path);
            EXPECT_EQ(status_within(read, 5s), 200) << path;
        }
        auto none = ask("GET", "/api/v1/jobs/job_none");
        EXPECT_EQ(status_within(none, 5s), 404);
        std::this_thread::sleep_for(500ms);
    }
    EXPECT_FALSE(status_within(list, 0ms)) << "a page of many rows is of the pool";
    done.set_value();
    writer.wait();
    EXPECT_EQ(status_within(stuck, 30s), 200);
    EXPECT_EQ(status_within(list, 30s), 200);
}

}  // namespace
}  // namespace divemesh
