// GET of a job with ?wait=, and lists with the newest first.
#include <gtest/gtest.h>

#include <future>
#include <set>
#include <thread>

#include "storage/job_store.hpp"
#include "tests/server/test_server.hpp"

namespace divemesh {
namespace {

using namespace std::chrono_literals;
using Clock = std::chrono::steady_clock;

class JobWaitTest : public testing::Test {
protected:
    std::string queued_job() {
        const auto made = server.post_json("/api/v1/dives/" + dive + "/jobs",
                                           server.admin(),
                                           {{"preset", "fast"}, {"options", {{"seed", ++seed}}}});
        EXPECT_EQ(made.status, 201) << made.body;
        return made.json()["id"];
    }
    RawResponse get(const std::string& target) {
        return server.request("GET", target, server.admin());
    }
    std::vector<std::string> ids(const std::string& query) {
        std::vector<std::string> found;
        std::string target = "/api/v1/jobs?kind=reconstruct&" + query;
        while (!target.empty()) {
            const auto page = get(target);
            EXPECT_EQ(page.status, 200) << page.body;
            const auto body = page.json();
            for (const auto& item : body["items"]) found.push_back(item["id"]);
            const std::string link = page.header("link");
            target = link.empty() ? "" : link.substr(1, link.find('>') - 1);
        }
        return found;
    }

    TestServer server;
    const std::string dive = server.make_dive("default", std::string(64, 'a'));
    int seed = 0;
};

TEST_F(JobWaitTest, AnswersWhenTheStateChanges) {
    const std::string path = "/api/v1/jobs/" + queued_job();
    auto answer = std::async(std::launch::async, [&] { return get(path + "?wait=30"); });
    EXPECT_EQ(answer.wait_for(700ms), std::future_status::timeout) << "it is still queued";
    const auto begin = Clock::now();
    storage::JobStore(server.catalog()).claim("test:1", 60s);
    EXPECT_EQ(answer.get().json()["state"], "running");
    EXPECT_LT(Clock::now() - begin, 5s);
}

TEST_F(JobWaitTest, AnswersAfterTheSecondsAndAtOnceIfItIsFinished) {
    const std::string path = "/api/v1/jobs/" + queued_job();
    auto begin = Clock::now();
    EXPECT_EQ(get(path + "?wait=1").json()["state"], "queued");
    EXPECT_GE(Clock::now() - begin, 1s);
    EXPECT_EQ(server.request("POST", path + "/cancel", server.admin()).status, 200);
    begin = Clock::now();
    EXPECT_EQ(get(path + "?wait=60").json()["state"], "cancelled");
    EXPECT_LT(Clock::now() - begin, 5s);
    for (const char* wait : {"61", "-1", "x", "", "1.5"})
        EXPECT_EQ(get(path + "?wait=" + wait).status, 400) << wait;
    EXPECT_EQ(get("/api/v1/jobs/job_none?wait=1").status, 404);
}

// More clients wait than there are threads; others are served meanwhile, and the server stops.
TEST_F(JobWaitTest, CostsNoThreadAndEndsWithTheServer) {
    const std::string path = "/api/v1/jobs/" + queued_job() + "?wait=60";
    std::vector<RawClient> waiting;
    for (int i = 0; i < 30; ++i) {
        waiting.emplace_back(server.port());
        waiting.back().send(request_head(
            "GET", path, {{"Authorization", "Bearer " + server.admin()}}, std::nullopt));
    }
    std::this_thread::sleep_for(300ms);
    auto begin = Clock::now();
    EXPECT_EQ(get("/api/v1/jobs").status, 200);
    EXPECT_LT(Clock::now() - begin, 2s);
    begin = Clock::now();
    server.stop();
    EXPECT_LT(Clock::now() - begin, 5s);
    for (RawClient& client : waiting) {
        const auto answer = client.receive();
        ASSERT_TRUE(answer);
        EXPECT_EQ(answer->status, 200);
    }
}

TEST_F(JobWaitTest, ListsTheNewestFirst) {
    std::vector<std::string> made;
    for (int i = 0; i < 7; ++i) made.push_back(queued_job());
    const auto oldest = ids("limit=3");
    EXPECT_EQ(oldest, ids("limit=3&order=oldest"));
    EXPECT_EQ(std::set<std::string>(oldest.begin(), oldest.end()),
              std::set<std::string>(made.begin(), made.end()));
    auto newest = ids("limit=3&order=newest");
    EXPECT_EQ(newest, std::vector<std::string>(oldest.rbegin(), oldest.rend()));
    EXPECT_EQ(ids("limit=1&order=newest&state=queued").size(), 7U);
    EXPECT_EQ(get("/api/v1/jobs?order=up").status, 400);
    EXPECT_EQ(get("/api/v1/tokens?order=newest").status, 400);
    server.make_dive("default", std::string(64, 'b'));
    const auto dives = get("/api/v1/dives?order=newest&fields=archive_sha256").json()["items"];
    ASSERT_EQ(dives.size(), 2U);
    EXPECT_EQ(dives[1]["archive_sha256"], std::string(64, 'a'));
}

}  // namespace
}  // namespace divemesh
