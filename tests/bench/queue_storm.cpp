// The queue under fire: 10,000 jobs, 8 workers, 100 kills. Exits with 1 when anything was lost or
// done twice to effect.
#include "tests/end_to_end/queue_storm.hpp"

#include <CLI/App.hpp>
#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>
#include <csignal>
#include <iostream>
#include <memory>

#include "tests/postgresql_server.hpp"

int main(int argc, char** argv) {
    divemesh::QueueStorm storm{.program = DIVEMESH_PROGRAM,
                               .fake_worker = FAKE_WORKER,
                               .num_jobs = 10'000,
                               .num_workers = 8,
                               .num_kills = 100};
    CLI::App app("Kills workers and server while jobs run.");
    app.add_option("--jobs", storm.num_jobs);
    app.add_option("--workers", storm.num_workers);
    app.add_option("--kills", storm.num_kills);
    app.add_option("--seed", storm.seed);
    bool on_postgresql = false;
    app.add_flag("--postgresql", on_postgresql, "catalog in PostgreSQL, which is killed as well");
    CLI11_PARSE(app, argc, argv);

    std::unique_ptr<divemesh::PostgresqlServer> database;
    if (on_postgresql) {
        database = std::make_unique<divemesh::PostgresqlServer>();
        database->run("CREATE DATABASE catalog");
        storm.catalog_url = database->url("catalog");
        storm.kill_database = [&database] {
            database->stop(SIGQUIT);
            database->start();
        };
    }
    const auto report = divemesh::run_queue_storm(storm);
    std::cout << report.num_succeeded << " of " << storm.num_jobs << " jobs succeeded in "
              << report.num_attempts << " attempts, " << report.num_kills << " kills ("
              << report.num_database_kills << " of the database), " << report.num_redriven
              << " redriven, " << report.seconds << " s\n";
    for (const auto& complaint : report.complaints) std::cout << complaint << '\n';
    return report.complaints.empty() && report.num_succeeded == storm.num_jobs ? 0 : 1;
}
