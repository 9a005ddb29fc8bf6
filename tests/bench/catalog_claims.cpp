// divemesh_catalog_claims [--engine sqlite|postgresql] [--clients N] [--jobs N]: how many jobs a
// second clients claim and complete through one catalog, each with connections of its own as a
// worker process has them, and how long a job that is added to an idle queue waits for its start.
// PostgreSQL runs on a Unix socket with its usual settings, so every commit is synced. Prints one
// JSON.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <atomic>
#include <chrono>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <soci/soci.h>
#include <string>
#include <thread>
#include <vector>

#include "schemas/content_hash.hpp"
#include "storage/catalog.hpp"
#include "storage/dive_store.hpp"
#include "storage/job_store.hpp"
#include "storage/queue_signal.hpp"
#include "storage/upload_store.hpp"
#include "tests/bench/machine.hpp"
#include "tests/postgresql_server.hpp"
#include "tests/temporary_folder.hpp"
#include "worker/stats/median.hpp"

namespace divemesh::storage {
namespace {

using Clock = std::chrono::steady_clock;
using namespace std::chrono_literals;

struct Plan {
    std::string engine = "postgresql";
    int num_clients = 16;
    int num_jobs = 4000;
    int num_added = 100;  // one by one, to an idle queue
};

double seconds_since(Clock::time_point began) {
    return std::chrono::duration<double>(Clock::now() - began).count();
}

// A client with a catalog of its own.
struct Client {
    explicit Client(const std::string& url) : catalog(url) {}

    Catalog catalog;
    JobStore jobs{catalog};
};

Dive make_dive(Catalog& catalog) {
    const Upload upload = UploadStore(catalog).create({.project = "default", .length_bytes = 0});
    const Dive dive = DiveStore(catalog)
                          .create({.upload_id = upload.id,
                                   .project = "default",
                                   .archive_sha256 = sha256_hex("dive"),
                                   .blob = "dives/a/archive"})
                          .dive;
    JobStore jobs(catalog);
    jobs.finish_intake(jobs.claim("intake", 1min)->lease, {.num_frames = 1000});
    return dive;
}

NewJob job_of(const Dive& dive, int number) {
    return {.dive_id = dive.id, .preset = "standard", .options = {{"seed", number}}};
}

// All jobs are there before the clients begin.
nlohmann::json claim_all(const std::string& url, const Plan& plan, const Dive& dive) {
    Catalog catalog(url);
    JobStore jobs(catalog);
    for (int i = 0; i < plan.num_jobs; ++i) jobs.enqueue(job_of(dive, i));
    std::vector<std::unique_ptr<Client>> clients;
    for (int i = 0; i < plan.num_clients; ++i) clients.push_back(std::make_unique<Client>(url));
    std::atomic<int> num_completed = 0;
    const auto began = Clock::now();
    {
        std::vector<std::jthread> threads;
        for (const auto& client : clients)
            threads.emplace_back([&client, &num_completed] {
                while (const auto claim = client->jobs.claim("worker", 1min))
                    if (client->jobs.succeed(claim->lease, {})) ++num_completed;
            });
    }
    const double seconds = seconds_since(began);
    return {{"num_completed", num_completed.load()},
            {"seconds", seconds},
            {"jobs_per_s", num_completed / seconds}};
}

// Claims as a worker does, until `num_left` jobs are done, and notes what each had waited.
void claim_added(Client& client,
                 const std::string& url,
                 std::atomic<int>& num_left,
                 std::vector<double>& waits_ms) {
    const auto signal = listen_to_queue(url);
    while (num_left > 0) {
        const auto claim = client.jobs.claim("worker", 1min);
        if (claim) {
            waits_ms.push_back(
                static_cast<double>(claim->job.started_at_ms - claim->job.created_at_ms));
            client.jobs.succeed(claim->lease, {});
            --num_left;
        } else if (signal) {
            signal->wait(500ms);
        } else {
            std::this_thread::sleep_for(500ms);
        }
    }
}

// Jobs are added one by one to an idle queue.
nlohmann::json add_one_by_one(const std::string& url, const Plan& plan, const Dive& dive) {
    Catalog catalog(url);
    JobStore jobs(catalog);
    std::atomic<int> num_left = plan.num_added;
    std::vector<std::vector<double>> waits_ms(static_cast<std::size_t>(plan.num_clients));
    std::vector<std::unique_ptr<Client>> clients;
    for (int i = 0; i < plan.num_clients; ++i) clients.push_back(std::make_unique<Client>(url));
    {
        std::vector<std::jthread> threads;
        for (std::size_t i = 0; i < clients.size(); ++i)
            threads.emplace_back([&, i] { claim_added(*clients[i], url, num_left, waits_ms[i]); });
        std::this_thread::sleep_for(2s);  // all of them wait
        for (int i = 0; i < plan.num_added; ++i) {
            jobs.enqueue(job_of(dive, -1 - i));
            std::this_thread::sleep_for(100ms);
        }
    }
    std::vector<double> all_ms;
    for (const auto& own : waits_ms) all_ms.insert(all_ms.end(), own.begin(), own.end());
    std::sort(all_ms.begin(), all_ms.end());
    return {{"num_added", all_ms.size()},
            {"median_ms", stats::upper_median(all_ms)},
            {"p95_ms", all_ms.at(all_ms.size() * 95 / 100)}};
}

nlohmann::json measure(const std::string& url, const Plan& plan) {
    Catalog catalog(url);
    const Dive dive = make_dive(catalog);
    return {{"engine", plan.engine},
            {"num_clients", plan.num_clients},
            {"added_to_started", add_one_by_one(url, plan, dive)},
            {"claimed_and_completed", claim_all(url, plan, dive)}};
}

nlohmann::json run(const Plan& plan) {
    if (plan.engine == "sqlite") {
        const TemporaryFolder folder;
        return measure("sqlite://" + (folder / "catalog.db").string(), plan);
    }
    const PostgresqlServer server(std::vector<std::string>{});
    server.run("CREATE DATABASE catalog");
    return measure(server.url("catalog"), plan);
}

}  // namespace
}  // namespace divemesh::storage

int main(int argc, char** argv) {
    CLI::App app("Measures how fast jobs are claimed through a catalog.");
    divemesh::storage::Plan plan;
    app.add_option("--engine", plan.engine)->check(CLI::IsMember({"sqlite", "postgresql"}));
    app.add_option("--clients", plan.num_clients)->check(CLI::Range(1, 64));
    app.add_option("--jobs", plan.num_jobs)->check(CLI::Range(1, 1'000'000));
    app.add_option("--added", plan.num_added)->check(CLI::Range(1, 10'000));
    CLI11_PARSE(app, argc, argv);
    nlohmann::json result = divemesh::storage::run(plan);
    result["machine"] = divemesh::bench::describe_machine();
    std::cout << result.dump(2) << std::endl;
    return 0;
}
