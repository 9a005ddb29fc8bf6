#include "storage/schedule_store.hpp"

#include <gtest/gtest.h>

#include <barrier>
#include <thread>

#include "tests/storage/store_fixture.hpp"

namespace divemesh::storage {
namespace {

class ScheduleStoreTest : public StoreTest {
protected:
    Dive tagged_dive(const std::string& name, const std::string& tag = "yearly") {
        const Dive dive = create_dive(name).dive;
        finish_intake(dive, {.tags = {tag}});
        return dive;
    }
    Schedule schedule(const std::string& cron = "* * * * *") {
        return schedules_.create(
            {.project = "default", .cron = cron, .tag = "yearly", .preset = "fast"});
    }
    void let_pass(const Schedule& schedule, int minutes = 5) {
        catalog_.transaction([&](soci::session& session) {
            const std::int64_t due_ms = Catalog::now_ms(session) - minutes * 60'000;
            session << "UPDATE schedules SET next_run_ms = :due WHERE id = :id", soci::use(due_ms),
                soci::use(schedule.id);
        });
    }
    std::size_t num_reports() {
        return jobs_.list({.kind = JobKind::AccuracyReport}, {.limit = 200}).items.size();
    }

    ScheduleStore schedules_{catalog_};
};

TEST_F(ScheduleStoreTest, ReportsEveryDiveOfItsTag) {
    const Dive a = tagged_dive("a");
    tagged_dive("b");
    tagged_dive("c", "other");
    const Schedule made = schedule();
    EXPECT_EQ(schedules_.run_due(""), 0) << "not due yet";
    let_pass(made);
    std::vector<std::string> notes;
    const auto note = [&](soci::session&, const Schedule& schedule, int num_jobs) {
        notes.push_back(schedule.tag + " " + std::to_string(num_jobs));
    };
    EXPECT_EQ(schedules_.run_due("", note), 2);
    EXPECT_EQ(notes, std::vector<std::string>{"yearly 2"});
    EXPECT_EQ(schedules_.run_due(""), 0) << "five missed minutes are one run";
    const Schedule after = schedules_.get(made.id);
    EXPECT_EQ(after.last_num_jobs, 2);
    EXPECT_GT(after.next_run_ms, after.last_run_ms);
    const auto reports = jobs_.list({.dive_id = a.id, .kind = JobKind::AccuracyReport}, {}).items;
    ASSERT_EQ(reports.size(), 1U);
    EXPECT_EQ(reports[0].options["tag"], "yearly");
}

TEST_F(ScheduleStoreTest, TwoServersRunATickOnceAndARestartDoesNotRepeatIt) {
    for (int i = 0; i < 5; ++i) tagged_dive("dive " + std::to_string(i));
    const Schedule made = schedule();
    for (int round = 0; round < 5; ++round) {
        let_pass(made);
        std::barrier start(4);
        std::atomic<int> num_jobs = 0;
        {
            std::vector<std::jthread> servers;
            for (int i = 0; i < 4; ++i)
                servers.emplace_back([&] {
                    Catalog own(url());
                    start.arrive_and_wait();
                    num_jobs += ScheduleStore(own).run_due("");
                });
        }
        EXPECT_EQ(num_jobs, round == 0 ? 5 : 0) << "the same work is under way";
        Catalog restarted(url());
        EXPECT_EQ(ScheduleStore(restarted).run_due(""), 0);
    }
    EXPECT_EQ(num_reports(), 5U);
}

TEST_F(ScheduleStoreTest, AClockThatIsSetBackHoldsNothingUp) {
    const Schedule made = schedule();
    catalog_.transaction([&](soci::session& session) {
        const std::int64_t ahead_ms = Catalog::now_ms(session) + 86'400'000;
        session << "UPDATE schedules SET last_run_ms = :ahead, next_run_ms = :ahead WHERE id = :id",
            soci::use(ahead_ms, "ahead"), soci::use(made.id, "id");
    });
    tagged_dive("a");
    EXPECT_EQ(schedules_.run_due(""), 0);
    EXPECT_LE(schedules_.get(made.id).next_run_ms, made.created_at_ms + 180'000);
}

TEST_F(ScheduleStoreTest, SaysWhatKeptItFromAReport) {
    const Schedule made = schedule();
    let_pass(made);
    schedules_.run_due("");
    EXPECT_EQ(schedules_.get(made.id).last_problem, "no dive has this tag");
}

TEST_F(ScheduleStoreTest, AProjectThatHasTooMuchGetsNoReportAndItSaysWhy) {
    const Dive dive = tagged_dive("a");
    const Schedule made = schedule();
    catalog_.transaction([&](soci::session& session) {
        session << "UPDATE dives SET archive_bytes = 1001 WHERE id = :id", soci::use(dive.id);
    });
    let_pass(made);
    EXPECT_EQ(schedules_.run_due("", {}, 1000), 0);
    EXPECT_EQ(num_reports(), 0U);
    const Schedule after = schedules_.get(made.id);
    EXPECT_EQ(after.last_problem.rfind("project default has 1001 of 1000 bytes", 0), 0U)
        << after.last_problem;
    let_pass(made);
    EXPECT_EQ(schedules_.run_due("", {}, 1001), 1);
    EXPECT_EQ(schedules_.get(made.id).last_problem, "");
}

TEST_F(ScheduleStoreTest, NonsenseIsRefusedAndWhatIsGoneIsNotRun) {
    EXPECT_TRUE(throws_code(ErrorCode::InvalidArgument, [&] { schedule("every day"); }));
    EXPECT_TRUE(throws_code(ErrorCode::InvalidArgument, [&] { schedule("0 0 30 2 *"); }));
    tagged_dive("a");
    const Schedule made = schedule();
    EXPECT_EQ(schedules_.list("default", {}).items.size(), 1U);
    EXPECT_TRUE(schedules_.list("others", {}).items.empty());
    let_pass(made);
    schedules_.remove(made.id);
    EXPECT_EQ(schedules_.run_due(""), 0);
    EXPECT_TRUE(throws_code(ErrorCode::NotFound, [&] { schedules_.get(made.id); }));
}

}  // namespace
}  // namespace divemesh::storage
