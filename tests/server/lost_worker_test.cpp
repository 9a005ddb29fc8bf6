// A worker is gone and no other one polls.
#include <gtest/gtest.h>

#include <soci/soci.h>
#include <thread>

#include "schemas/content_hash.hpp"
#include "storage/dive_removal.hpp"
#include "storage/job_store.hpp"
#include "storage/worker_store.hpp"
#include "tests/server/test_server.hpp"

namespace divemesh {
namespace {

using namespace std::chrono_literals;

server::ServerConfig with_short_looks() {
    server::ServerConfig config;
    config.timeouts.leases = 50ms;
    config.keep_lost_workers = 1h;
    return config;
}

class LostWorkerTest : public testing::Test {
protected:
    // A job whose worker is not heard of any more.
    Job lost_job() {
        jobs.enqueue({.project = "default", .dive_id = dive, .preset = "standard"});
        return jobs.claim("boat:1", 100ms).value().job;
    }
    bool reaches(const Job& job, JobState state) {
        for (const auto end = std::chrono::steady_clock::now() + 10s;
             std::chrono::steady_clock::now() < end;
             std::this_thread::sleep_for(10ms))
            if (jobs.get(job.id).state == state) return true;
        return false;
    }

    TestServer server{with_short_looks()};
    storage::JobStore jobs{server.catalog()};
    const std::string dive = server.make_dive("default", sha256_hex("1"));
};

TEST_F(LostWorkerTest, ItsJobIsQueuedAgain) {
    const Job job = lost_job();

    EXPECT_TRUE(reaches(job, JobState::Queued));
    EXPECT_EQ(jobs.attempts(job.id).at(0).state, AttemptState::LeaseLost);
}

TEST_F(LostWorkerTest, ItLeavesTheListUnlessItWasToldToDrain) {
    storage::WorkerStore workers(server.catalog());
    for (const char* name : {"dead:1", "drained:1", "recent:1"}) workers.report(name, 1);
    workers.set_draining("drained:1", true);
    const auto silent_for = [&](const std::string& name, std::chrono::milliseconds silence) {
        const std::int64_t ms = silence.count();
        server.catalog().transaction([&](soci::session& session) {
            session << "UPDATE workers SET seen_at_ms = seen_at_ms - :ms WHERE name = :name",
                soci::use(ms), soci::use(name);
        });
    };
    silent_for("recent:1", 59min);
    silent_for("drained:1", 61min);
    silent_for("dead:1", 61min);

    std::vector<std::string> names;
    for (const auto end = std::chrono::steady_clock::now() + 10s;
         names.size() != 2 && std::chrono::steady_clock::now() < end;
         std::this_thread::sleep_for(10ms)) {
        names.clear();
        for (const Worker& worker : workers.list()) names.push_back(worker.name);
    }
    EXPECT_EQ(names, (std::vector<std::string>{"drained:1", "recent:1"}));
    EXPECT_FALSE(workers.get("recent:1").alive);
}

TEST_F(LostWorkerTest, ItsJobIsCancelledWhenThatWasAskedFor) {
    const Job job = lost_job();
    jobs.cancel(job.id);

    EXPECT_TRUE(reaches(job, JobState::Cancelled));
}

TEST_F(LostWorkerTest, ItsDiveCanGo) {
    const Job job = lost_job();
    storage::DiveRemoval removal(server.catalog());
    removal.remove(dive, 0ms, [](const Dive&) {});
    ASSERT_TRUE(removal.expired(10).empty());

    ASSERT_TRUE(reaches(job, JobState::Cancelled));
    EXPECT_EQ(removal.expired(10).size(), 1U);
}

}  // namespace
}  // namespace divemesh
