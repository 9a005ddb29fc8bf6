#include "worker/runner/job_runner.hpp"

#include <algorithm>
#include <condition_variable>
#include <csignal>
#include <cstdio>
#include <memory>
#include <mutex>
#include <optional>
#include <random>
#include <thread>
#include <unistd.h>
#include <vector>

#include "schemas/log.hpp"
#include "storage/blob_store.hpp"
#include "storage/catalog.hpp"
#include "storage/data_id.hpp"
#include "storage/job_store.hpp"
#include "storage/queue_signal.hpp"
#include "worker/runner/attempt_runner.hpp"
#include "worker/runner/registration.hpp"
#include "worker/runner/work_folder.hpp"
#include "worker/runner/worker_gate.hpp"

namespace divemesh::runner {
namespace {

constexpr std::int64_t kMaxOpenFiles = 1024;

// Returns a unique name: two containers may share host name and process ids.
std::string make_worker_name() {
    char host[256] = "unknown";
    gethostname(host, sizeof host - 1);
    char random[9];
    std::snprintf(random, sizeof random, "%08x", std::random_device{}());
    return std::string(host) + ":" + std::to_string(getpid()) + ":" + random;
}

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

// What the slots of a worker share.
struct Slots {
    const WorkerConfig& config;
    const std::string& name;
    storage::JobStore& jobs;
    storage::BlobStore& blobs;
    WorkerGate& gate;
    Registration& registration;
};

std::optional<storage::Claim> claim_if_able(const Slots& slots) {
    const std::string waits_for = slots.gate.waits_for();
    slots.registration.set_waits_for(waits_for);
    return waits_for.empty() ? slots.jobs.claim(slots.name, slots.config.lease) : std::nullopt;
}

// Waits before the catalog is asked for jobs again.
class Pause {
public:
    explicit Pause(const WorkerConfig& config)
        : at_most_(config.poll_every), signal_(storage::listen_to_queue(config.catalog_url)) {}

    void wait(const std::stop_token& stop) {
        if (signal_) return signal_->wait(at_most_);
        std::unique_lock lock(mutex_);
        wake_.wait_for(lock, stop, at_most_, [] { return false; });
    }

private:
    std::chrono::milliseconds at_most_;
    std::unique_ptr<storage::QueueSignal> signal_;
    std::mutex mutex_;
    std::condition_variable_any wake_;
};

void run_slot(const Slots& slots, const std::stop_token& stop) {
    Pause pause(slots.config);
    while (!stop.stop_requested()) {
        bool worked = false;
        try {
            if (auto claim = claim_if_able(slots)) {
                log_info({{"event", "attempt_began"},
                          {"job", claim->job.id},
                          {"attempt", claim->lease.attempt}});
                AttemptRunner(slots.config, slots.jobs, slots.blobs, slots.gate, std::move(*claim))
                    .run(stop);
                worked = true;
            }
        } catch (const std::exception& error) {  // the catalog is unreachable: try again
            log_warning({{"event", "worker_failed"}, {"what", error.what()}});
        }
        if (!worked) pause.wait(stop);
    }
}

}  // namespace

void run_worker(const WorkerConfig& config, std::stop_token stop) {
    std::signal(SIGXFSZ, SIG_IGN);  // a file that cannot grow is an error of write()
    storage::Catalog catalog(config.catalog_url, storage::Opening::ExistingOnly);
    const auto blobs = storage::open_blob_store(config.blobs_url, storage::Opening::ExistingOnly);
    storage::require_same_data(catalog, *blobs);
    storage::JobStore jobs(catalog);
    const std::string name = make_worker_name();
    Registration registration(catalog, name, config.num_slots);

    const WorkFolder work_folder(config.work_folder);
    WorkerConfig own = config;
    own.work_folder = work_folder.path();
    isolate(own);
    WorkerGate gate(own, catalog, *blobs);
    const Slots slots{own, name, jobs, *blobs, gate, registration};
    std::vector<std::thread> threads;
    threads.reserve(static_cast<std::size_t>(config.num_slots));
    for (int i = 0; i < config.num_slots; ++i) threads.emplace_back([&] { run_slot(slots, stop); });
    for (std::thread& thread : threads) thread.join();
}

}  // namespace divemesh::runner
