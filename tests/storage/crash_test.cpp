// Processes that are killed or race with each other, on one catalog.
#include <gtest/gtest.h>

#include <cstdint>
#include <functional>
#include <memory>
#include <vector>

#include "schemas/file_descriptor.hpp"
#include "tests/storage/child.hpp"

namespace divemesh::storage {
namespace {

class CrashTest : public testing::Test, protected InFolder {
protected:
    using Children = std::vector<std::unique_ptr<Child>>;

    Children make_children(int count, const std::function<void(Stores&)>& work) const {
        Children children;
        for (int i = 0; i < count; ++i) children.push_back(std::make_unique<Child>(url(), work));
        return children;
    }
    static void run_at_once(const Children& children) {
        for (const auto& child : children) child->go();
        for (const auto& child : children) EXPECT_EQ(child->end(), 0);
    }
};

TEST_F(CrashTest, AProcessKilledInsideATransactionLeavesNothingOfIt) {
    Child child(url(), [](Stores& stores) {
        stores.catalog_.transaction([](soci::session& session) {
            session << "UPDATE jobs SET state = 'cancelled' WHERE state = 'queued'";
            EventStore::append(session, {.subject = "job", .type = "job.state"});
            kill(getpid(), SIGKILL);
        });
    });
    Stores stores(url());
    const Job job = stores.enqueue(stores.ready_dive());
    const auto newest = stores.events_.newest_sequence();

    child.go();
    ASSERT_TRUE(WIFSIGNALED(child.end()));

    EXPECT_EQ(stores.jobs_.get(job.id).state, JobState::Queued);
    EXPECT_EQ(stores.events_.newest_sequence(), newest);
    EXPECT_TRUE(stores.jobs_.claim("worker", Stores::kLong));
}

TEST_F(CrashTest, WhatACallHasReturnedSurvivesTheKillOfItsProcess) {
    constexpr std::size_t kIdBytes = 24;  // "job_" and 20 more
    int ends[2];
    ASSERT_EQ(pipe(ends), 0);
    const FileDescriptor read_end(ends[0]);
    const FileDescriptor write_end(ends[1]);
    Child child(url(), [&](Stores& stores) {
        const Dive dive = stores.dives_.list({}, {}).items.at(0);
        for (;;) {
            const std::string id = stores.enqueue(dive).id;
            if (write(write_end.get(), id.data(), kIdBytes) != kIdBytes) _exit(2);
        }
    });
    Stores stores(url());
    stores.ready_dive();

    child.go();
    std::vector<std::string> ids(20, std::string(kIdBytes, ' '));
    for (std::string& id : ids)
        ASSERT_EQ(read(read_end.get(), id.data(), kIdBytes), static_cast<ssize_t>(kIdBytes));
    child.kill_now();
    child.end();

    for (const std::string& id : ids) EXPECT_EQ(stores.jobs_.get(id).state, JobState::Queued);
}

TEST_F(CrashTest, ProcessesThatClaimAtOnceNeverGetTheSameJob) {
    const Children children = make_children(4, [](Stores& stores) {
        while (const auto claim = stores.jobs_.claim("worker", Stores::kLong))
            if (!stores.jobs_.succeed(claim->lease, {})) _exit(3);
    });
    Stores stores(url());
    const Dive dive = stores.ready_dive();
    for (int i = 0; i < 24; ++i) stores.enqueue(dive);

    run_at_once(children);

    const auto jobs = stores.jobs_.list({.kind = JobKind::Reconstruct}, {}).items;
    ASSERT_EQ(jobs.size(), 24U);
    for (const Job& job : jobs) {
        EXPECT_EQ(job.state, JobState::Succeeded);
        EXPECT_EQ(stores.jobs_.attempts(job.id).size(), 1u);
    }
}

TEST_F(CrashTest, ProcessesThatOpenANewCatalogAtOnceAgreeOnItsSchema) {
    run_at_once(make_children(4, [](Stores& stores) { stores.finished_upload(); }));

    EXPECT_EQ(Stores(url()).events_.since(0, "", 100).size(), 8u);
}

TEST_F(CrashTest, TheSameRecordingFromManyProcessesAtOnceIsOneDive) {
    const Children children = make_children(4, [](Stores& stores) {
        stores.dives_.create(Stores::request(stores.finished_upload(), "wreck", "paper"));
    });
    Stores stores(url());

    run_at_once(children);

    EXPECT_EQ(stores.dives_.list({}, {}).items.size(), 1u);
    EXPECT_EQ(stores.jobs_.list({}, {}).items.size(), 2u);  // one intake, one reconstruction
    EXPECT_TRUE(stores.uploads_.list_open().empty());
}

}  // namespace
}  // namespace divemesh::storage
