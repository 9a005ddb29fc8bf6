#include "tests/end_to_end/queue_storm.hpp"

#include <gtest/gtest.h>

#include <csignal>
#include <gmock/gmock.h>

#include "tests/postgresql_server.hpp"

namespace divemesh {
namespace {

TEST(QueueStormTest, KillsOfWorkersAndServerLoseNoJobAndDoNoneTwice) {
    const StormReport report = run_queue_storm({.program = DIVEMESH_PROGRAM,
                                                .fake_worker = FAKE_WORKER,
                                                .num_jobs = 300,
                                                .num_workers = 3,
                                                .num_kills = 10});

    EXPECT_THAT(report.complaints, testing::IsEmpty());
    EXPECT_EQ(report.num_succeeded, 300);
    EXPECT_EQ(report.num_kills, 10);
}

TEST(PostgresqlStormTest, KillsOfWorkersServerAndDatabaseLoseNoJobAndDoNoneTwice) {
    if (!PostgresqlServer::is_installed()) GTEST_SKIP() << "PostgreSQL is not installed";
    PostgresqlServer database;
    database.run("CREATE DATABASE catalog");
    const StormReport report = run_queue_storm({.program = DIVEMESH_PROGRAM,
                                                .fake_worker = FAKE_WORKER,
                                                .catalog_url = database.url("catalog"),
                                                .kill_database =
                                                    [&] {
                                                        database.stop(SIGQUIT);
                                                        database.start();
                                                    },
                                                .num_jobs = 200,
                                                .num_workers = 3,
                                                .num_kills = 12});

    EXPECT_THAT(report.complaints, testing::IsEmpty());
    EXPECT_EQ(report.num_succeeded, 200);
    EXPECT_EQ(report.num_kills, 12);
    EXPECT_GE(report.num_database_kills, 1);
}

}  // namespace
}  // namespace divemesh
