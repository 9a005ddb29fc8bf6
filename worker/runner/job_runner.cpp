#include "worker/runner/job_runner.hpp"

#include <algorithm>
#include <condition_variable>
#include <csignal>
#include <cstdio>
#include <mutex>
#include <random>
#include <thread>
#include <unistd.h>
#include <vector>

#include "schemas/log.hpp"
#include "storage/blob_store.hpp"
#include "storage/catalog.hpp"
#include "storage/job_store.hpp"
#include "storage/worker_store.hpp"
#include "worker/runner/attempt_runner.hpp"
#include "worker/runner/work_folder.hpp"

namespace divemesh::runner {
namespace {

using namespace std::chrono_literals;
constexpr auto kReportEvery = 5s;
constexpr std::int64_t kMaxOpenFiles = 1024;

// Returns a unique name: two containers may share host name and process ids.
std::string make_worker_name() {
    char host[256] = "unknown";
    gethostname(host, sizeof host - 1);
    char random[9];
    std::snprintf(random, sizeof random, "%08x", std::random_device{}());
    return std::string(host) + ":" + std::to_string(getpid()) + ":" + random;
}

// Reports every few seconds that the worker is alive, and in the end that it has stopped.
class Registration {
public:
    Registration(storage::Catalog& catalog, std::string name, int num_slots)
        : workers_(catalog), name_(std::move(name)), num_slots_(num_slots) {
        workers_.report(name_, num_slots_);
        thread_ = std::jthread([this](const std::stop_token& stop) { run(stop); });
    }
    ~Registration() {
        thread_.request_stop();
        thread_.join();
        try {
            workers_.remove(name_);
        } catch (const std::exception& error) {
            log_warning({{"event", "not_registered"}, {"what", error.what()}});
        }
    }
    Registration(const Registration&) = delete;
    Registration& operator=(const Registration&) = delete;

private:
    void run(const std::stop_token& stop) {
        std::mutex mutex;
        std::condition_variable_any wake;
        while (!stop.stop_requested()) {
            std::unique_lock lock(mutex);
            wake.wait_for(lock, stop, kReportEvery, [] { return false; });
            if (stop.stop_requested()) return;
            try {
                workers_.report(name_, num_slots_);
            } catch (const std::exception& error) {
                log_warning({{"event", "not_registered"}, {"what", error.what()}});
            }
        }
    }

    storage::WorkerStore workers_;
    std::string name_;
    int num_slots_;
    std::jthread thread_;
};

// Sets the default limits of an attempt. With a limit above the machine's memory the kernel would
// choose which process to kill.
void isolate(WorkerConfig& config) {
    ProcessLimits& limits = config.limits;
    const auto memory_bytes = static_cast<std::int64_t>(sysconf(_SC_PHYS_PAGES)) *
                              static_cast<std::int64_t>(sysconf(_SC_PAGESIZE));
    if (limits.max_memory_bytes <= 0)
        limits.max_memory_bytes = memory_bytes / 10 * 9 / std::max(1, config.num_slots);
    if (limits.max_open_files <= 0) limits.max_open_files = kMaxOpenFiles;
    if (limits.max_cpu_s <= 0)
        limits.max_cpu_s = std::chrono::ceil<std::chrono::seconds>(config.deadline).count() *
                           std::max(1U, std::thread::hardware_concurrency());
    limits.no_network = can_cut_network();
    if (!limits.no_network)
        log_warning({{"event", "network_kept"},
                     {"what",
                      "attempts have network access: the worker is not root and user namespaces "
                      "are not available"}});
}

// Stops new work on a nearly full disk: reading and deleting need the rest.
class RoomOnDisk {
public:
    explicit RoomOnDisk(const WorkerConfig& config) : config_(config) {}

    bool is_there() {
        std::error_code unknown;
        const auto space = std::filesystem::space(config_.work_folder, unknown);
        const bool full =
            !unknown &&
            static_cast<std::int64_t>(space.available) - kMinScratch_bytes < config_.min_free_bytes;
        if (full != was_full_)
            log_warning({{"event", full ? "disk_nearly_full" : "disk_has_room"},
                         {"folder", config_.work_folder.string()}});
        was_full_ = full;
        return !full;
    }

private:
    const WorkerConfig& config_;
    bool was_full_ = false;
};

void run_slot(const WorkerConfig& config,
              const std::string& name,
              storage::JobStore& jobs,
              storage::BlobStore& blobs,
              const std::stop_token& stop) {
    std::mutex mutex;
    std::condition_variable_any wake;
    RoomOnDisk room(config);
    while (!stop.stop_requested()) {
        bool worked = false;
        try {
            auto claim = room.is_there() ? jobs.claim(name, config.lease) : std::nullopt;
            if (claim) {
                log_info({{"event", "attempt_began"},
                          {"job", claim->job.id},
                          {"attempt", claim->lease.attempt}});
                AttemptRunner(config, jobs, blobs, std::move(*claim)).run(stop);
                worked = true;
            }
        } catch (const std::exception& error) {  // the catalog is unreachable: try again
            log_warning({{"event", "worker_failed"}, {"what", error.what()}});
        }
        if (worked) continue;
        std::unique_lock lock(mutex);
        wake.wait_for(lock, stop, config.poll_every, [] { return false; });
    }
}

}  // namespace

void run_worker(const WorkerConfig& config, std::stop_token stop) {
    std::signal(SIGXFSZ, SIG_IGN);  // a file that cannot grow is an error of write()
    storage::Catalog catalog(config.catalog_url);
    const auto blobs = storage::open_blob_store(config.blobs_url);
    storage::JobStore jobs(catalog);
    const std::string name = make_worker_name();
    const Registration registration(catalog, name, config.num_slots);

    const WorkFolder work_folder(config.work_folder);
    WorkerConfig own = config;
    own.work_folder = work_folder.path();
    isolate(own);
    std::vector<std::thread> slots;
    slots.reserve(static_cast<std::size_t>(config.num_slots));
    for (int i = 0; i < config.num_slots; ++i)
        slots.emplace_back([&] { run_slot(own, name, jobs, *blobs, stop); });
    for (std::thread& slot : slots) slot.join();
}

}  // namespace divemesh::runner
