#include <gtest/gtest.h>

#include "schemas/json.hpp"
#include "schemas/shown_job.hpp"

namespace divemesh {
namespace {

// Documents of servers that are older than the fields.
TEST(JobJsonTest, ReadsAQueueThatStatesNotHowManyResultsItKeeps) {
    const nlohmann::json older = {
        {"project", "wrecks"}, {"paused", true}, {"max_running", 2}, {"num_jobs", {{"queued", 1}}}};

    const auto queue = older.get<Queue>();

    EXPECT_TRUE(queue.paused);
    EXPECT_EQ(queue.max_running, 2);
    EXPECT_EQ(queue.keep_results, 0);
}

TEST(JobJsonTest, ReadsAJobThatStatesOnlyWhatEarlierVersionsKnew) {
    Job job;
    job.id = "job_1";
    job.kind = JobKind::Reconstruct;
    job.forecast = Forecast{.position = 3, .starts_in_s = 10.0, .takes_s = 20.0};
    nlohmann::json older = job;
    for (const char* name : {"verdict", "findings"}) older.erase(name);

    const auto read = older.get<ShownJob>();

    EXPECT_EQ(read.id, "job_1");
    EXPECT_FALSE(read.verdict);
    EXPECT_TRUE(read.findings.empty());
    EXPECT_EQ(read.waits_for, "");
    EXPECT_EQ(read.deleted_at_ms, 0);
    EXPECT_EQ(read.forecast->position, 3);
}

}  // namespace
}  // namespace divemesh
