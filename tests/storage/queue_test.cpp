// Order, limits, pauses, drains, forecasts: what the queue does with more than one job.
#include <gmock/gmock.h>

#include "storage/dive_removal.hpp"
#include "storage/job_changes.hpp"
#include "storage/queue_forecast.hpp"
#include "storage/queue_store.hpp"
#include "storage/worker_store.hpp"
#include "tests/storage/store_fixture.hpp"

namespace divemesh::storage {
namespace {

using testing::ElementsAre;

class QueueTest : public StoreTest {
protected:
    Dive ready_dive_of(const std::string& project, const std::string& content) {
        const Dive dive = dives_.create(request(finished_upload(project), content)).dive;
        finish_intake(dive, {.num_frames = 100, .duration_s = 10.0});
        return dives_.get(dive.id);
    }
    void age(const Job& job, std::int64_t by_ms) {
        catalog_.transaction([&](soci::session& session) {
            session << "UPDATE jobs SET created_at_ms = created_at_ms - :by,"
                       " queue_rank_ms = queue_rank_ms - :by WHERE id = :id",
                soci::use(by_ms, "by"), soci::use(job.id, "id");
        });
    }
    void set_speed(double seconds_per_frame) {
        catalog_.transaction([&](soci::session& session) {
            session << "INSERT INTO job_speeds (kind, preset, seconds_per_unit)"
                       " VALUES ('reconstruct', 'standard', :speed)",
                soci::use(seconds_per_frame, "speed");
        });
    }
    bool starts_nothing() { return !jobs_.claim("worker", kLong); }

    QueueStore queues_{catalog_};
    WorkerStore workers_{catalog_};
    QueueForecast forecast_{std::chrono::milliseconds(0)};
};

TEST_F(QueueTest, TenMinutesOfWaitingAreWorthAStepOfPriority) {
    const Dive dive = ready_dive();
    const Job urgent = jobs_.enqueue({.dive_id = dive.id, .priority = 3}).job;
    const Job patient = enqueue(dive);
    const Job fresh = enqueue(dive);

    age(patient, 31 * 60'000);

    EXPECT_EQ(claim().job.id, patient.id);
    EXPECT_EQ(claim().job.id, urgent.id);
    EXPECT_EQ(claim().job.id, fresh.id);
}

TEST_F(QueueTest, AJobIsMovedForwardByItsPriority) {
    const Dive dive = ready_dive();
    enqueue(dive);
    const Job late = enqueue(dive);

    EXPECT_EQ(jobs_.change(late.id, {.priority = 1}).priority, 1);

    EXPECT_EQ(claim().job.id, late.id);
    EXPECT_TRUE(throws_code(ErrorCode::Conflict, [&] { jobs_.change(late.id, {.priority = 2}); }));
    EXPECT_TRUE(throws_code(ErrorCode::InvalidArgument,
                            [&] { jobs_.change(late.id, {.priority = 1000}); }));
}

TEST_F(QueueTest, TheSameWorkIsQueuedOnce) {
    const Dive dive = ready_dive();
    const NewJob work{.dive_id = dive.id, .preset = "fast", .options = {{"voxel_m", 0.02}}};
    const EnqueuedJob first = jobs_.enqueue(work);
    EXPECT_TRUE(first.is_new);
    NewJob other = work;
    other.options["voxel_m"] = 0.03;
    NewJob same = work;
    same.options["num_threads"] = 2;  // changes no byte of the result

    EXPECT_TRUE(jobs_.enqueue(other).is_new);
    EXPECT_FALSE(jobs_.enqueue(same).is_new);
    EXPECT_EQ(jobs_.enqueue(same).job.id, first.job.id);
    jobs_.cancel(first.job.id);
    EXPECT_TRUE(jobs_.enqueue(same).is_new);
    EXPECT_TRUE(throws_code(ErrorCode::Conflict, [&] { jobs_.retry(first.job.id); }));
}

TEST_F(QueueTest, TheDatabaseItselfRefusesTheSameWorkTwice) {
    const Dive dive = ready_dive();
    enqueue(dive);
    enqueue(dive);

    EXPECT_THROW(catalog_.transaction([&](soci::session& session) {
        session << "UPDATE jobs SET unique_key = 'x' WHERE kind = 'reconstruct'";
    }),
                 soci::soci_error);
}

TEST_F(QueueTest, APausedQueueStartsNothingUntilItIsResumed) {
    const Job job = enqueue(ready_dive());

    EXPECT_TRUE(queues_.change("", {.paused = true}).paused);
    EXPECT_TRUE(starts_nothing());
    create_dive("reef");
    EXPECT_TRUE(starts_nothing());
    queues_.change("", {.paused = false});

    EXPECT_TRUE(claim().job.kind == JobKind::Intake);
    EXPECT_EQ(claim().job.id, job.id);
}

TEST_F(QueueTest, APausedProjectLetsTheOthersPass) {
    enqueue(ready_dive_of("lab", "wreck"));
    const Job other = enqueue(ready_dive_of("club", "reef"));
    queues_.change("lab", {.paused = true});

    EXPECT_EQ(claim().job.id, other.id);
    EXPECT_TRUE(starts_nothing());
    EXPECT_FALSE(queues_.get("club").paused);
}

TEST_F(QueueTest, AProjectRunsNoMoreJobsAtATimeThanItMay) {
    const Dive wreck = ready_dive_of("lab", "wreck");
    const Dive reef = ready_dive_of("club", "reef");
    for (int i = 0; i < 3; ++i) enqueue(wreck);
    const Job other = enqueue(reef);
    queues_.change("lab", {.max_running = 2});

    const Lease first = claim().lease;
    claim();
    EXPECT_EQ(claim().job.id, other.id);
    EXPECT_TRUE(starts_nothing());
    dives_.create(request(finished_upload("lab"), "an intake is not held"));
    EXPECT_EQ(claim().job.kind, JobKind::Intake);
    EXPECT_TRUE(starts_nothing());
    jobs_.succeed(first, {});

    EXPECT_EQ(claim().job.project, "lab");
    EXPECT_EQ(queues_.get("lab").num_jobs.at("running"), 3);  // an intake among them
}

TEST_F(QueueTest, AllProjectsTogetherRunNoMoreThanTheQueueMay) {
    enqueue(ready_dive_of("lab", "wreck"));
    enqueue(ready_dive_of("club", "reef"));
    queues_.change("", {.max_running = 1});

    claim();

    EXPECT_TRUE(starts_nothing());
    EXPECT_TRUE(
        throws_code(ErrorCode::InvalidArgument, [&] { queues_.change("", {.max_running = -1}); }));
}

TEST_F(QueueTest, AWorkerThatDrainsTakesNothingMore) {
    const Dive dive = ready_dive();
    enqueue(dive);
    const Job second = enqueue(dive);
    workers_.report("worker", 2);
    const Claim running = claim();

    EXPECT_EQ(workers_.set_draining("worker", true).num_running, 1);
    EXPECT_TRUE(starts_nothing());
    workers_.report("worker", 2);  // still there, still draining
    EXPECT_TRUE(starts_nothing());
    EXPECT_TRUE(jobs_.succeed(running.lease, {}));
    EXPECT_EQ(jobs_.claim("another", kLong)->job.id, second.id);
    workers_.set_draining("worker", false);
    enqueue(dive);

    EXPECT_FALSE(starts_nothing());
}

TEST_F(QueueTest, WorkersComeAndGo) {
    workers_.report("b", 1);
    workers_.report("a", 3);
    catalog_.transaction([](soci::session& session) {
        session << "UPDATE workers SET seen_at_ms = seen_at_ms - 30000 WHERE name = 'b'";
    });

    const auto workers = workers_.list();

    ASSERT_EQ(workers.size(), 2u);
    EXPECT_EQ(workers[0].num_slots, 3);
    EXPECT_TRUE(workers[0].alive);
    EXPECT_FALSE(workers[1].alive);
    workers_.remove("b");
    EXPECT_EQ(workers_.list().size(), 1u);
    EXPECT_TRUE(throws_code(ErrorCode::NotFound, [&] { workers_.set_draining("b", true); }));
    EXPECT_TRUE(throws_code(ErrorCode::NotFound, [&] { workers_.set_draining("", true); }));
}

TEST_F(QueueTest, SaysWhereAJobStandsAndWhenItStarts) {
    const Dive dive = ready_dive_of("lab", "wreck");  // 100 frames
    set_speed(0.5);
    workers_.report("worker", 2);
    std::vector<Job> waiting;
    for (int i = 0; i < 5; ++i) waiting.push_back(enqueue(dive));

    const auto last = forecast_.of(waiting[4], catalog_);
    ASSERT_TRUE(last);
    EXPECT_EQ(last->position, 5);
    EXPECT_EQ(last->takes_s, 50.0);
    EXPECT_EQ(last->starts_in_s, 100.0);  // two at a time, two rounds of 50 s before it
    EXPECT_EQ(forecast_.of(waiting[0], catalog_)->position, 1);
    EXPECT_EQ(forecast_.of(waiting[0], catalog_)->starts_in_s, 0.0);

    const Job moved = jobs_.change(waiting[4].id, {.priority = 5});
    EXPECT_EQ(forecast_.of(moved, catalog_)->position, 1);
    EXPECT_FALSE(forecast_.of(claim().job, catalog_));
}

TEST_F(QueueTest, SaysNothingOfWhatIsNotKnown) {
    const Dive dive = ready_dive_of("lab", "wreck");
    const Job first = enqueue(dive);
    const Job second = enqueue(dive);
    EXPECT_EQ(forecast_.of(first, catalog_)->starts_in_s, -1.0);  // no worker polls
    workers_.report("worker", 1);

    EXPECT_EQ(forecast_.of(first, catalog_)->starts_in_s, 0.0);
    EXPECT_EQ(forecast_.of(first, catalog_)->takes_s, -1.0);  // nothing was measured yet
    EXPECT_EQ(forecast_.of(second, catalog_)->starts_in_s, -1.0);
    set_speed(0.5);
    EXPECT_EQ(forecast_.of(second, catalog_)->starts_in_s, 50.0);
    queues_.change("lab", {.paused = true});
    EXPECT_EQ(forecast_.of(first, catalog_)->starts_in_s, -1.0);
}

TEST_F(QueueTest, SaysWhyAJobDoesNotStart) {
    const Job job = enqueue(ready_dive_of("lab", "wreck"));
    const auto reason = [&] { return forecast_.waits_for(jobs_.get(job.id), catalog_); };
    const auto starts_in_s = [&] { return forecast_.of(jobs_.get(job.id), catalog_)->starts_in_s; };
    EXPECT_EQ(reason(), "worker");
    workers_.report("worker", 1);
    EXPECT_EQ(reason(), "");
    EXPECT_EQ(starts_in_s(), 0.0);

    for (const char* obstacle : {"disk", "storage"}) {
        workers_.report("worker", 1, obstacle);
        EXPECT_EQ(reason(), obstacle);
        EXPECT_EQ(starts_in_s(), -1.0);
    }
    workers_.report("another", 1);  // one that takes jobs is enough
    EXPECT_EQ(reason(), "");
    EXPECT_EQ(queues_.waits_for(), "");
    workers_.remove("another");
    workers_.report("worker", 1);
    workers_.set_draining("worker", true);
    EXPECT_EQ(reason(), "drain");
    EXPECT_EQ(queues_.waits_for(), "drain");
    EXPECT_EQ(starts_in_s(), -1.0);
    workers_.set_draining("worker", false);
    queues_.change("lab", {.paused = true});
    EXPECT_EQ(reason(), "queue_paused");
    EXPECT_EQ(queues_.waits_for(), "");  // other projects go on
    queues_.change("lab", {.paused = false});
    queues_.change("", {.paused = true});
    EXPECT_EQ(reason(), "queue_paused");
    EXPECT_EQ(queues_.waits_for(), "queue_paused");
    EXPECT_EQ(starts_in_s(), -1.0);
}

TEST_F(QueueTest, SaysThatALimitKeepsAJobBack) {
    const Dive wreck = ready_dive_of("lab", "wreck");
    workers_.report("worker", 4);
    set_speed(0.5);
    enqueue(wreck);
    const Job second = enqueue(wreck);
    const Job other = enqueue(ready_dive_of("club", "reef"));
    queues_.change("lab", {.max_running = 1});
    EXPECT_EQ(forecast_.waits_for(second, catalog_), "");
    const Lease running = claim().lease;

    EXPECT_EQ(forecast_.waits_for(second, catalog_), "limit");
    EXPECT_EQ(forecast_.of(second, catalog_)->starts_in_s, -1.0);
    EXPECT_EQ(forecast_.waits_for(other, catalog_), "");
    jobs_.succeed(running, {});
    EXPECT_EQ(forecast_.waits_for(second, catalog_), "");
}

TEST_F(QueueTest, SaysWhatHoldsAJob) {
    workers_.report("worker", 1);
    const Dive dive = ready_dive_of("lab", "wreck");
    const Job parent = enqueue(dive);
    const Job child =
        jobs_.enqueue({.dive_id = dive.id, .preset = "fast", .parents = {parent.id}}).job;

    EXPECT_EQ(forecast_.waits_for(child, catalog_), "parent");
    EXPECT_EQ(forecast_.waits_for(jobs_.change(parent.id, {.paused = true}), catalog_), "paused");
    jobs_.change(parent.id, {.paused = false});
    JobStore(catalog_).fail(claim().lease, {ErrorCode::Unavailable, "crashed"});
    const Job failed = jobs_.get(parent.id);
    EXPECT_EQ(forecast_.waits_for(failed, catalog_), "retry");
    EXPECT_EQ(forecast_.of(failed, catalog_)->starts_in_s, 0.0);  // within five seconds
    EXPECT_EQ(forecast_.waits_for(jobs_.cancel(parent.id), catalog_), "");
}

TEST_F(QueueTest, LearnsHowLongJobsTake) {
    const Dive dive = ready_dive_of("lab", "wreck");
    workers_.report("worker", 1);
    const auto run = [&](std::int64_t for_ms, bool from_cache) {
        enqueue(dive);
        const Claim running = claim();
        catalog_.transaction([&](soci::session& session) {
            session << "UPDATE jobs SET started_at_ms = started_at_ms - :by WHERE id = :id",
                soci::use(for_ms, "by"), soci::use(running.job.id, "id");
        });
        jobs_.report_stage(running.lease, {"track", 1.0, from_cache});
        jobs_.succeed(running.lease, {});
    };

    run(200'000, false);
    run(1'000, true);  // tells nothing
    EXPECT_EQ(forecast_.of(enqueue(dive), catalog_)->takes_s, 200.0);
    claim();
    run(400'000, false);

    EXPECT_EQ(forecast_.of(enqueue(dive), catalog_)->takes_s, 250.0);
}

TEST_F(QueueTest, DeadLettersAreListedAndDriven) {
    const Dive dive = ready_dive();
    std::vector<std::string> dead;
    for (int i = 0; i < 3; ++i) {
        dead.push_back(enqueue(dive, 1).id);
        jobs_.fail(claim().lease, {ErrorCode::Unavailable, "crashed"});
    }
    EXPECT_EQ(jobs_.list({.state = JobState::Dead}, {}).items.size(), 3u);
    EXPECT_TRUE(jobs_.redrive("other", 10).empty());

    EXPECT_EQ(jobs_.redrive("default", 2).size(), 2u);
    EXPECT_EQ(jobs_.get(dead[0]).state, JobState::Queued);
    EXPECT_EQ(jobs_.get(dead[2]).state, JobState::Dead);
    EXPECT_EQ(jobs_.redrive("", 1000).size(), 1u);
    EXPECT_EQ(claim().job.id, dead[0]);
    EXPECT_TRUE(throws_code(ErrorCode::InvalidArgument, [&] { jobs_.redrive("", 0); }));
}

TEST_F(QueueTest, NothingIsDrivenOfAProjectThatHasTooMuch) {
    const Dive dive = ready_dive();
    const Job dead = enqueue(dive, 1);
    jobs_.fail(claim().lease, {ErrorCode::Unavailable, "crashed"});
    const auto redrive = [&](const std::string& project) {
        return jobs_.redrive(project, 10, 1'000'000);
    };
    catalog_.transaction([&](soci::session& session) {
        session << "UPDATE dives SET archive_bytes = 1000001 WHERE id = :id", soci::use(dive.id);
    });
    EXPECT_TRUE(throws_code(ErrorCode::OutOfQuota, [&] { redrive("default"); }));
    EXPECT_TRUE(throws_code(ErrorCode::OutOfQuota, [&] { redrive(""); }));
    EXPECT_TRUE(redrive("other").empty());
    EXPECT_EQ(jobs_.get(dead.id).state, JobState::Dead);
    catalog_.transaction([&](soci::session& session) {
        session << "UPDATE dives SET archive_bytes = 1000000 WHERE id = :id", soci::use(dive.id);
    });
    EXPECT_EQ(redrive("").size(), 1u);
}

TEST_F(QueueTest, NothingIsDrivenOfADiveThatWasDeleted) {
    const Dive deleted = ready_dive("deleted");
    const Job dead = enqueue(deleted, 1);
    jobs_.fail(claim().lease, {ErrorCode::Unavailable, "crashed"});
    DiveRemoval(catalog_).remove(deleted.id, kLong, [](const Dive&) {});

    EXPECT_TRUE(jobs_.redrive("", 10).empty());
    EXPECT_EQ(jobs_.get(dead.id).state, JobState::Dead);

    DiveRemoval(catalog_).restore(deleted.id);
    EXPECT_EQ(jobs_.redrive("", 10).size(), 1u);
}

TEST_F(QueueTest, KeepsTheLogOfEveryAttempt) {
    const Job job = enqueue(ready_dive());
    for (const char* text : {"first\n", "second\n"}) {
        const Lease lease = claim().lease;
        jobs_.append_log(lease, text);
        jobs_.fail(lease, {ErrorCode::Unavailable, "crashed"});
    }

    EXPECT_EQ(jobs_.log(job.id, 1), "first\n");
    EXPECT_EQ(jobs_.log(job.id, 2), "second\n");
    EXPECT_EQ(jobs_.log(job.id), "second\n");
    EXPECT_TRUE(throws_code(ErrorCode::NotFound, [&] { jobs_.log(job.id, 3); }));
}

TEST_F(QueueTest, KeepsNoMoreStagesThanThereCanBe) {
    const Job job = enqueue(ready_dive());
    const Lease lease = claim().lease;

    for (int i = 0; i < 40; ++i) EXPECT_TRUE(jobs_.report_stage(lease, {"track", 0.1, false}));
    EXPECT_TRUE(jobs_.report_stage(lease, {std::string(65, 'x'), 0.1, false}));

    EXPECT_EQ(jobs_.get(job.id).stages.size(), 32u);
}

TEST_F(QueueTest, TellsTheStagesOfTheNewestAttempt) {
    const Job job = enqueue(ready_dive());
    const Lease first = claim().lease;
    jobs_.report_stage(first, {"track", 2.0, false});
    jobs_.fail(first, {ErrorCode::Unavailable, "crashed"});
    const Lease second = claim().lease;
    EXPECT_TRUE(jobs_.get(job.id).stages.empty());
    EXPECT_FALSE(jobs_.report_stage(first, {"optimise", 1.0, false}));

    jobs_.report_stage(second, {"track", 0.1, true});
    jobs_.report_stage(second, {"optimise", 1.0, false});
    jobs_.succeed(second, {});

    const auto stages = jobs_.get(job.id).stages;
    ASSERT_EQ(stages.size(), 2u);
    EXPECT_EQ(stages[0].name, "track");
    EXPECT_TRUE(stages[0].from_cache);
    EXPECT_FALSE(stages[1].from_cache);
}

}  // namespace
}  // namespace divemesh::storage
