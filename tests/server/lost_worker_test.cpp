// A worker is gone and no other one polls.
#include <gtest/gtest.h>

#include <thread>

#include "schemas/content_hash.hpp"
#include "storage/dive_removal.hpp"
#include "storage/job_store.hpp"
#include "tests/server/test_server.hpp"

namespace divemesh {
namespace {

using namespace std::chrono_literals;

server::ServerConfig with_short_looks() {
    server::ServerConfig config;
    config.timeouts.leases = 50ms;
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
