// What the catalog answers by itself, without HTTP, with 10,000 jobs in it.
#include <benchmark/benchmark.h>
#include <memory>
#include <random>
#include <soci/soci.h>
#include <string>
#include <vector>

#include "schemas/json.hpp"
#include "storage/catalog.hpp"
#include "storage/dive_store.hpp"
#include "storage/job_store.hpp"
#include "storage/queue_forecast.hpp"
#include "storage/upload_store.hpp"
#include "tests/temporary_folder.hpp"

namespace divemesh::storage {
namespace {

constexpr int kNumJobs = 10'000;

class FullCatalog {
public:
    FullCatalog() {
        const Upload upload =
            UploadStore(catalog).create({.project = "default", .length_bytes = 0});
        const Dive dive = DiveStore(catalog)
                              .create({.upload_id = upload.id,
                                       .project = "default",
                                       .archive_sha256 = std::string(64, 'a'),
                                       .blob = "dives/a/archive"})
                              .dive;
        JobStore jobs(catalog);
        jobs.finish_intake(jobs.claim("worker", std::chrono::minutes(1))->lease,
                           {.num_frames = 1000});
        const Job job = jobs.enqueue({.dive_id = dive.id, .preset = "standard"}).job;
        catalog.transaction([&](soci::session& session) {
            session << "WITH RECURSIVE n(i) AS (SELECT 1 UNION ALL SELECT i + 1 FROM n WHERE i < "
                    << kNumJobs << ") INSERT INTO jobs (id, project, dive_id, kind, state, preset,"
                    << " max_attempts, progress, created_at_ms, unique_key, queue_rank_ms)"
                    << " SELECT printf('job_%020d', i), project, dive_id, kind, state, preset,"
                    << " max_attempts, progress, created_at_ms + i, printf('%d', i),"
                    << " queue_rank_ms + i FROM n, jobs WHERE id = '" << job.id << "'";
        });
        for (int i = 1; i <= kNumJobs; ++i) {
            const std::string digits = std::to_string(i);
            ids.push_back("job_" + std::string(20 - digits.size(), '0') + digits);
        }
    }

    TemporaryFolder folder;
    Catalog catalog{(folder / "catalog.db").string()};
    std::vector<std::string> ids;
};

FullCatalog& full() {
    static FullCatalog catalog;
    return catalog;
}

const std::string& random_id() {
    static thread_local std::mt19937 random{std::random_device{}()};
    return full().ids[random() % full().ids.size()];
}

void get_job(benchmark::State& state) {
    JobStore jobs(full().catalog);
    for (auto _ : state) benchmark::DoNotOptimize(jobs.get(random_id()));
    state.SetItemsProcessed(state.iterations());
}
BENCHMARK(get_job)->Threads(1)->Threads(2)->UseRealTime();

void get_job_as_json(benchmark::State& state) {
    static QueueForecast forecast;
    JobStore jobs(full().catalog);
    for (auto _ : state) {
        Job job = jobs.get(random_id());
        job.forecast = forecast.of(job, full().catalog);
        benchmark::DoNotOptimize(nlohmann::json(job).dump());
    }
    state.SetItemsProcessed(state.iterations());
}
BENCHMARK(get_job_as_json)->Threads(1)->Threads(2)->UseRealTime();

void list_jobs(benchmark::State& state) {
    JobStore jobs(full().catalog);
    for (auto _ : state)
        benchmark::DoNotOptimize(jobs.list({.state = JobState::Queued}, {.limit = 50}));
}
BENCHMARK(list_jobs);

void take_forecast(benchmark::State& state) {
    QueueForecast forecast(std::chrono::milliseconds(0));
    const Job job = JobStore(full().catalog).get(full().ids.back());
    for (auto _ : state) benchmark::DoNotOptimize(forecast.of(job, full().catalog));
}
BENCHMARK(take_forecast)->Unit(benchmark::kMillisecond);

// And given back, so that there are always as many.
void claim_and_release(benchmark::State& state) {
    JobStore jobs(full().catalog);
    for (auto _ : state) jobs.release(jobs.claim("worker", std::chrono::minutes(1))->lease);
}
BENCHMARK(claim_and_release)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace divemesh::storage

BENCHMARK_MAIN();
