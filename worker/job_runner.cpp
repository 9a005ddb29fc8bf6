#include "worker/job_runner.hpp"

#include <condition_variable>
#include <csignal>
#include <cstring>
#include <fstream>
#include <functional>
#include <memory>
#include <mutex>
#include <nlohmann/json.hpp>
#include <optional>
#include <signal.h>
#include <spdlog/spdlog.h>
#include <thread>
#include <unistd.h>
#include <vector>

#include "schemas/error.hpp"
#include "storage/blob_store.hpp"
#include "storage/catalog.hpp"
#include "storage/job_store.hpp"
#include "worker/artifact_files.hpp"
#include "worker/attempt_protocol.hpp"
#include "worker/lease_keeper.hpp"
#include "worker/work_folder.hpp"

namespace divemesh::worker {
namespace {

using Clock = std::chrono::steady_clock;
using namespace std::chrono_literals;
constexpr auto kReadTimeout = 100ms;

std::string worker_name() {
    char host[256] = "unknown";
    gethostname(host, sizeof host - 1);
    return std::string(host) + ":" + std::to_string(getpid());
}

LeaseNews news_of(const storage::Renewal& renewal) {
    if (!renewal.valid) return LeaseNews::Lost;
    return renewal.cancel_requested ? LeaseNews::CancelRequested : LeaseNews::Valid;
}

// Why the parent ends a child before it is done.
enum class Stop { None, LeaseLost, Cancelled, Deadline, ShuttingDown };

// One attempt from claim to its end in the catalog. Everything it writes carries the lease.
class AttemptRunner {
public:
    AttemptRunner(const WorkerConfig& config,
                  storage::JobStore& jobs,
                  storage::BlobStore& blobs,
                  storage::Claim claim)
        : config_(config), jobs_(jobs), blobs_(blobs), claim_(std::move(claim)) {}

    void run(const std::stop_token& stop);

private:
    AttemptRequest write_request() const;
    void supervise(const LeaseKeeper& keeper, const std::stop_token& stop);
    void read_lines(std::string& buffer);
    void take(AttemptMessage message);
    Stop reason_to_stop(const LeaseKeeper& keeper, const std::stop_token& stop) const;
    void end_child(ChildProcess& child);
    void conclude_stopped();
    void conclude_without_result();
    void conclude(const AttemptMessage& result, const AttemptRequest& request);
    void publish_intake(const IntakeAnswer& answer, const AttemptRequest& request);
    std::vector<Artifact> store_artifacts(const AttemptRequest& request);
    void fail(const Failure& failure);
    void remove_blobs() const;
    bool persist(const std::function<bool()>& write) const;

    std::filesystem::path folder() const { return config_.work_folder / claim_.lease.lease_id; }
    std::string blob_prefix() const {
        return "jobs/" + claim_.job.id + "/attempt-" + std::to_string(claim_.lease.attempt) + "-" +
               claim_.lease.lease_id + "/";
    }

    const WorkerConfig& config_;
    storage::JobStore& jobs_;
    storage::BlobStore& blobs_;
    storage::Claim claim_;
    Clock::time_point started_ = Clock::now();
    Stop stop_ = Stop::None;
    std::optional<Clock::time_point> asked_to_end_;
    std::optional<AttemptMessage> result_;
    ProcessEnd end_;
};

void AttemptRunner::run(const std::stop_token& stop) {
    const LeaseKeeper keeper(
        {.renew = [this] { return news_of(jobs_.renew(claim_.lease, config_.lease)); },
         .look = [this] { return news_of(jobs_.look(claim_.lease)); }},
        {.lease = config_.lease,
         .renew_every = config_.renew_every,
         .look_every = config_.poll_every});
    try {
        const AttemptRequest request = write_request();
        supervise(keeper, stop);
        if (stop_ != Stop::None)
            conclude_stopped();
        else if (result_)
            conclude(*result_, request);
        else
            conclude_without_result();
    } catch (const Error& error) {
        fail({error.code(), error.what()});
    } catch (const std::filesystem::filesystem_error& error) {
        const bool full = error.code() == std::errc::no_space_on_device;
        fail({full ? ErrorCode::OutOfSpace : ErrorCode::Unavailable, error.what()});
    } catch (const std::exception& error) {
        spdlog::error("job {}: {}", claim_.job.id, error.what());
        fail({ErrorCode::Unavailable, "internal error of the worker; its log says more"});
    }
    std::error_code ignored;
    std::filesystem::remove_all(folder(), ignored);
}

AttemptRequest AttemptRunner::write_request() const {
    AttemptRequest request{.kind = claim_.job.kind,
                           .out = folder() / "out",
                           .scratch = folder() / "scratch",
                           .preset = claim_.job.preset,
                           .options = claim_.job.options};
    std::filesystem::create_directories(request.out);
    std::filesystem::create_directories(request.scratch);
    request.dive = blobs_.local_copy(claim_.dive.blob, folder() / "dive");
    if (config_.num_threads > 0 && !request.options.contains("num_threads"))
        request.options["num_threads"] = config_.num_threads;
    std::ofstream file(folder() / "request.json");
    file << nlohmann::json(request);
    file.close();
    if (!file) throw Error(ErrorCode::OutOfSpace, "cannot write into " + folder().string());
    return request;
}

// Reads the child's messages until it has ended, or ends it when there is a reason to.
void AttemptRunner::supervise(const LeaseKeeper& keeper, const std::stop_token& stop) {
    ChildProcess child(
        {config_.executable.string(), "attempt", (folder() / "request.json").string()},
        config_.limits);
    std::string buffer;
    for (bool open = true; !child.poll_end();) {
        if (open)
            open = child.read_some(buffer, kReadTimeout.count());
        else
            std::this_thread::sleep_for(kReadTimeout / 10);  // it is on its way out
        read_lines(buffer);
        if (stop_ == Stop::None) stop_ = reason_to_stop(keeper, stop);
        if (stop_ != Stop::None && !child.poll_end()) end_child(child);
    }
    for (std::size_t read = 1; read > 0;) {  // what is left in the pipe
        const std::size_t before = buffer.size();
        child.read_some(buffer, 0);
        read = buffer.size() - before;
    }
    read_lines(buffer);
    end_ = *child.poll_end();
}

void AttemptRunner::read_lines(std::string& buffer) {
    for (auto end = buffer.find('\n'); end != std::string::npos; end = buffer.find('\n')) {
        const std::string line = buffer.substr(0, end);
        buffer.erase(0, end + 1);
        try {
            take(decode_message(line));
        } catch (const Error& error) {  // the child's fault, not the recording's
            throw Error(ErrorCode::Unavailable, error.what());
        }
    }
    if (buffer.size() > kMaxLineBytes)
        throw Error(ErrorCode::Unavailable, "an attempt sent a line without an end");
}

void AttemptRunner::take(AttemptMessage message) {
    bool valid = true;
    try {  // a catalog that is out of reach for a moment must not end hours of work
        if (const auto* progress = std::get_if<Progress>(&message))
            valid = jobs_.report_progress(claim_.lease, *progress);
        else if (const auto* log = std::get_if<LogText>(&message))
            valid = jobs_.append_log(claim_.lease, log->text);
        else
            result_ = std::move(message);
    } catch (const std::exception& error) {
        spdlog::warn("job {}: progress not written: {}", claim_.job.id, error.what());
    }
    if (!valid) stop_ = Stop::LeaseLost;
}

Stop AttemptRunner::reason_to_stop(const LeaseKeeper& keeper, const std::stop_token& stop) const {
    if (keeper.lost()) return Stop::LeaseLost;
    if (keeper.cancel_requested()) return Stop::Cancelled;
    if (stop.stop_requested()) return Stop::ShuttingDown;
    if (Clock::now() - started_ > config_.deadline) return Stop::Deadline;
    return Stop::None;
}

// Whose lease is lost must not go on for a moment; all others may end by themselves first.
void AttemptRunner::end_child(ChildProcess& child) {
    const auto now = Clock::now();
    if (stop_ == Stop::LeaseLost) return child.signal_group(SIGKILL);
    if (!asked_to_end_) {
        asked_to_end_ = now;
        child.signal_group(SIGTERM);
    } else if (now - *asked_to_end_ > config_.cancel_grace) {
        child.signal_group(SIGKILL);
    }
}

void AttemptRunner::conclude_stopped() {
    switch (stop_) {
        case Stop::LeaseLost:
            spdlog::warn(
                "job {}: lease lost, attempt {} dropped", claim_.job.id, claim_.lease.attempt);
            return;
        case Stop::Cancelled: return fail({ErrorCode::Cancelled, "cancelled"});
        case Stop::ShuttingDown: persist([&] { return jobs_.release(claim_.lease); }); return;
        case Stop::Deadline:
            return fail({ErrorCode::Unavailable,
                         "the attempt took longer than its deadline: choose a faster preset or a "
                         "larger voxel_m, or give the worker more time"});
        case Stop::None: return;
    }
}

void AttemptRunner::conclude_without_result() {
    std::string message = "the attempt ended without a result, exit code " +
                          std::to_string(end_.exit_code) + "; see the job's log";
    if (end_.signal != 0)
        message = "the attempt was ended by signal " + std::to_string(end_.signal) + " (" +
                  strsignal(end_.signal) + "): if this repeats, report it with this dive" +
                  (end_.signal == SIGKILL ? "; SIGKILL often means that memory ran out" : "");
    fail({ErrorCode::Unavailable, message});
}

void AttemptRunner::conclude(const AttemptMessage& result, const AttemptRequest& request) {
    if (const auto* failure = std::get_if<Failure>(&result)) return fail(*failure);
    if (const auto* intake = std::get_if<IntakeAnswer>(&result))
        return publish_intake(*intake, request);
    if (end_.exit_code != 0 || end_.signal != 0) return conclude_without_result();
    const auto artifacts = store_artifacts(request);
    if (!persist([&] { return jobs_.succeed(claim_.lease, artifacts); })) remove_blobs();
}

void AttemptRunner::publish_intake(const IntakeAnswer& answer, const AttemptRequest& request) {
    storage::IntakeResult result{.findings = answer.findings,
                                 .name = answer.name,
                                 .site = answer.site,
                                 .tags = answer.tags,
                                 .content_sha256 = answer.content_sha256,
                                 .num_frames = answer.num_frames,
                                 .duration_s = answer.duration_s};
    if (answer.has_thumbnail) {
        result.thumbnail_blob = blob_prefix() + "thumbnail.jpg";
        blobs_.put_file(result.thumbnail_blob, request.out / "thumbnail.jpg");
    }
    if (!persist([&] { return jobs_.finish_intake(claim_.lease, result); })) remove_blobs();
}

// Every file the child left in its out folder, under keys of this attempt alone.
std::vector<Artifact> AttemptRunner::store_artifacts(const AttemptRequest& request) {
    auto artifacts = list_artifacts(request.out);
    for (Artifact& artifact : artifacts) {
        artifact.job_id = claim_.job.id;
        artifact.blob = blob_prefix() + artifact.name;
        blobs_.put_file(artifact.blob, request.out / artifact.name);
    }
    return artifacts;
}

void AttemptRunner::fail(const Failure& failure) {
    spdlog::info("job {}: attempt {}: {}", claim_.job.id, claim_.lease.attempt, failure.message);
    remove_blobs();
    persist([&] { return jobs_.fail(claim_.lease, failure); });
}

// Of this attempt alone, and never those of a success: a commit may have reached the catalog though
// its answer was an error. What cannot be removed is in nobody's way.
void AttemptRunner::remove_blobs() const {
    try {
        for (const Attempt& attempt : jobs_.attempts(claim_.job.id))
            if (attempt.number == claim_.lease.attempt && attempt.state == AttemptState::Succeeded)
                return;
        blobs_.remove_prefix(blob_prefix());
    } catch (const std::exception& error) {
        spdlog::warn("job {}: {}", claim_.job.id, error.what());
    }
}

// The last write of an attempt: a catalog that is out of reach is asked again for as long as the
// lease can last; after that the job is somebody else's.
bool AttemptRunner::persist(const std::function<bool()>& write) const {
    for (const auto give_up = Clock::now() + config_.lease;;) {
        try {
            return write();
        } catch (const Error& error) {
            if (error.code() != ErrorCode::Unavailable || Clock::now() > give_up) throw;
            spdlog::warn("job {}: result not written yet: {}", claim_.job.id, error.what());
        }
        std::this_thread::sleep_for(config_.poll_every);
    }
}

void run_slot(const WorkerConfig& config,
              storage::JobStore& jobs,
              storage::BlobStore& blobs,
              const std::stop_token& stop) {
    std::mutex mutex;
    std::condition_variable_any wake;
    while (!stop.stop_requested()) {
        bool worked = false;
        try {
            if (auto claim = jobs.claim(worker_name(), config.lease)) {
                spdlog::info("job {}: attempt {}", claim->job.id, claim->lease.attempt);
                AttemptRunner(config, jobs, blobs, std::move(*claim)).run(stop);
                worked = true;
            }
        } catch (const std::exception& error) {  // the catalog is out of reach: try again
            spdlog::error("worker: {}", error.what());
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

    const WorkFolder work_folder(config.work_folder);
    WorkerConfig own = config;
    own.work_folder = work_folder.path();
    std::vector<std::thread> slots;
    for (int i = 0; i < config.num_slots; ++i)
        slots.emplace_back([&] { run_slot(own, jobs, *blobs, stop); });
    for (std::thread& slot : slots) slot.join();
}

}  // namespace divemesh::worker
