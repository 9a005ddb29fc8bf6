// The queue under fire: 10,000 jobs, 8 workers, 100 kills. Exits with 1 when anything was lost or
// done twice to effect.
#include "tests/end_to_end/queue_storm.hpp"

#include <CLI/App.hpp>
#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>
#include <iostream>

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
    CLI11_PARSE(app, argc, argv);

    const auto report = divemesh::run_queue_storm(storm);
    std::cout << report.num_succeeded << " of " << storm.num_jobs << " jobs succeeded in "
              << report.num_attempts << " attempts, " << report.num_kills << " kills, "
              << report.num_redriven << " redriven, " << report.seconds << " s\n";
    for (const auto& complaint : report.complaints) std::cout << complaint << '\n';
    return report.complaints.empty() && report.num_succeeded == storm.num_jobs ? 0 : 1;
}
