#include "worker/runner/attempt_runner.hpp"

#include <algorithm>
#include <csignal>
#include <cstring>
#include <fstream>
#include <limits>
#include <memory>
#include <nlohmann/json.hpp>
#include <thread>
#include <utility>

#include "schemas/error.hpp"
#include "schemas/log.hpp"
#include "worker/runner/artifact_files.hpp"
#include "worker/runner/disk_room.hpp"
#include "worker/runner/own_storage.hpp"
#include "worker/runner/scratch_usage.hpp"

namespace divemesh::runner {
namespace {

using namespace std::chrono_literals;
constexpr auto kReadTimeout = 100ms;
constexpr auto kMeasureEvery = 2s;
constexpr std::int64_t kRoomAhead_bytes = std::int64_t{1} << 30;  // for what is written meanwhile
constexpr pid_t kNoProcess = -1;
constexpr auto kReportEvery = 500ms;
constexpr std::size_t kMaxPendingLogBytes = std::size_t{512} << 10;  // more than the catalog keeps
constexpr int kMaxReportedStages = 64;
constexpr std::int64_t kMinFusionMemory_bytes = std::int64_t{64} << 20;
constexpr int kExitOutOfMemory = 137;  // exit code of shells and containers for SIGKILL

LeaseStatus status_of_renewal(const storage::Renewal& renewal) {
    if (!renewal.valid) return LeaseStatus::Lost;
    return renewal.cancel_requested ? LeaseStatus::CancelRequested : LeaseStatus::Valid;
}

// Returns the failure of a child that ended without reporting one. A SIGKILL that we did not send
// means that the kernel needed memory.
Failure failure_of(const ProcessEnd& end) {
    if (end.signal == SIGKILL || end.exit_code == kExitOutOfMemory)
        return {
            .code = ErrorCode::OutOfMemory,
            .message = "the attempt was killed by the system, most likely because memory ran out"};
    if (end.signal == SIGXCPU)
        return {.code = ErrorCode::Unavailable,
                .message = "the attempt used more processor time than allowed",
                .remedy =
                    "choose a faster preset or a larger voxel_m, or give the worker more "
                    "time"};
    if (end.signal != 0)
        return {.code = ErrorCode::Unavailable,
                .message = "the attempt was ended by signal " + std::to_string(end.signal) + " (" +
                           strsignal(end.signal) + ")",
                .remedy = "if this repeats, report it with this dive"};
    return {
        .code = ErrorCode::Unavailable,
        .message = "the attempt ended without a result, exit code " + std::to_string(end.exit_code),
        .remedy = "see the log of the job"};
}

void bring(storage::BlobStore& blobs,
           const std::string& key,
           const std::filesystem::path& destination,
           const std::string& sha256) {
    const auto there = blobs.local_copy(key, destination, sha256);
    if (there != destination)
        std::filesystem::create_symlink(std::filesystem::absolute(there), destination);
}

Finding set_aside(const TruthFile& file) {
    return {Severity::Warning,
            "truth_set_aside",
            file.name,
            "this " + std::string(to_string(file.kind)) + " (" + file.id +
                ") is newer than the one used for the report, but cannot be read: " + file.problem,
            "correct it and send it again, or delete it from the truth files of the dive"};
}

// Sets the options that need the least memory without changing a byte of the result.
void lower(nlohmann::json& options) {
    options["num_threads"] = 1;
    options["fusion_memory_bytes"] = kMinFusionMemory_bytes;
}

}  // namespace

void AttemptRunner::run(const std::stop_token& stop) {
    const LeaseKeeper keeper(
        {.renew = [this] { return status_of_renewal(jobs_.renew(claim_.lease, config_.lease)); },
         .check_lease = [this] { return status_of_renewal(jobs_.check_lease(claim_.lease)); }},
        {.lease = config_.lease,
         .renew_every = config_.renew_every,
         .check_every = config_.poll_every});
    try {
        const auto request = on_own_storage([&] { return write_request(); });
        inputs_bytes_ = scratch_usage_bytes(folder(), kNoProcess);
        heard_ = Clock::now();  // fetching from an object store may have taken hours
        supervise(keeper, stop);
        if (stop_ != Stop::None)
            conclude_stopped();
        else if (result_)
            conclude(*result_, request);
        else
            fail(failure_of(end_));
    } catch (const Error& error) {
        fail({error.code(), error.what()});
    } catch (const std::exception& error) {
        log_warning({{"event", "worker_failed"}, {"job", claim_.job.id}, {"what", error.what()}});
        fail({ErrorCode::Unavailable, "internal error of the worker: see its log"});
    }
}

void AttemptRunner::remove_scratch() const {
    std::error_code ignored;
    std::filesystem::remove_all(folder(), ignored);
}

attempt::AttemptRequest AttemptRunner::write_request() const {
    attempt::AttemptRequest request{.kind = claim_.job.kind,
                                    .out = folder() / "out",
                                    .scratch = folder() / "scratch",
                                    .cache = config_.cache_folder,
                                    .cache_bytes = config_.cache_bytes,
                                    .preset = claim_.job.preset,
                                    .options = claim_.job.options};
    std::filesystem::create_directories(request.out);
    std::filesystem::create_directories(request.scratch);
    request.dive = fetch_dive();
    fetch_inputs(request);
    if (claim_.job.lowered) lower(request.options);
    if (config_.num_threads > 0 && !request.options.contains("num_threads"))
        request.options["num_threads"] = config_.num_threads;
    std::ofstream file(folder() / "request.json");
    file << nlohmann::json(request);
    file.close();
    if (!file) throw Error(ErrorCode::OutOfSpace, "cannot write into " + folder().string());
    return request;
}

// Returns the dive's archive on this machine. The cache of stages gives way to a copy.
std::filesystem::path AttemptRunner::fetch_dive() const {
    const auto fetch = [&] {
        return blobs_.local_copy(claim_.dive.blob, folder() / "dive", claim_.dive.archive_sha256);
    };
    try {
        return fetch();
    } catch (const Error& error) {
        if (error.code() != ErrorCode::OutOfSpace ||
            !DiskRoom(config_).make(claim_.dive.archive_bytes + kRoomAhead_bytes))
            throw;
        return fetch();
    }
}

// Fetches the inputs of a report or a comparison besides its dive, as files named as in a
// reconstruction's folder.
void AttemptRunner::fetch_inputs(attempt::AttemptRequest& request) const {
    if (claim_.job.kind != JobKind::AccuracyReport && claim_.job.kind != JobKind::Compare) return;
    const storage::JobInputs inputs = jobs_.inputs(claim_.job);
    for (const auto& artifacts : inputs.reconstructions) {
        request.reconstructions.push_back(
            folder() / ("reconstruction-" + std::to_string(request.reconstructions.size())));
        fetch_reconstruction(artifacts, request.reconstructions.back());
    }
    for (const auto& [option, file] : inputs.truth) {
        const auto own_folder = folder() / ("truth-" + option);
        std::filesystem::create_directories(own_folder);
        request.truth[option] = own_folder / plain_name(file.name);
        bring(blobs_, file.blob, request.truth[option], file.sha256);
    }
    for (const TruthFile& file : inputs.set_aside) request.findings.push_back(set_aside(file));
    request.history = inputs.history;
}

void AttemptRunner::fetch_reconstruction(const std::vector<Artifact>& artifacts,
                                         const std::filesystem::path& into) const {
    std::filesystem::create_directories(into);
    for (const Artifact& artifact : artifacts) {
        const std::filesystem::path name = artifact.name;
        if (!is_read_again(artifact.name) || !is_below(name)) continue;
        std::filesystem::create_directories((into / name).parent_path());
        bring(blobs_, artifact.blob, into / name, artifact.sha256);
    }
}

// Returns how much of the disk the attempt may use. It is less than what there is, so a disk that
// is full has been filled by others.
std::int64_t AttemptRunner::scratch_share() const {
    const bool is_configured = config_.scratch_bytes > 0;
    const auto room = DiskRoom(config_).reachable_bytes();
    if (!room)
        return is_configured ? config_.scratch_bytes : std::numeric_limits<std::int64_t>::max();
    const std::int64_t usable = *room / 10 * 9;
    if (is_configured) return std::min(config_.scratch_bytes, std::max(kMinScratch_bytes, usable));
    return std::max(kMinScratch_bytes, usable / std::max(1, config_.num_slots));
}

// Returns the configured limits, and those that follow from the attempt's time and disk space.
ProcessLimits AttemptRunner::limits() {
    scratch_bytes_ = scratch_share();
    DiskRoom(config_).make(kRoomAhead_bytes);
    ProcessLimits limits = config_.limits;
    if (limits.max_file_bytes <= 0) limits.max_file_bytes = scratch_bytes_;
    return limits;
}

// Reads the child's messages until it has ended; ends it if there is a reason to.
void AttemptRunner::supervise(const LeaseKeeper& keeper, const std::stop_token& stop) {
    ChildProcess child(
        {config_.executable.string(), "attempt", (folder() / "request.json").string()}, limits());
    std::string buffer;
    for (bool open = true; !child.poll_end();) {
        if (open)
            open = child.read_some(buffer, kReadTimeout.count());
        else
            std::this_thread::sleep_for(kReadTimeout / 10);  // the child is about to end
        read_lines(buffer);
        report_pending(kReportEvery);
        if (stop_ == Stop::None) stop_ = reason_to_stop(keeper, stop, child);
        if (stop_ != Stop::None && !child.poll_end()) end_child(child);
    }
    for (std::size_t read = 1; read > 0;) {  // the rest of the pipe
        const std::size_t before = buffer.size();
        child.read_some(buffer, 0);
        read = buffer.size() - before;
    }
    read_lines(buffer);
    report_pending(0ms);
    end_ = *child.poll_end();
}

void AttemptRunner::read_lines(std::string& buffer) {
    for (auto end = buffer.find('\n'); end != std::string::npos; end = buffer.find('\n')) {
        const std::string line = buffer.substr(0, end);
        buffer.erase(0, end + 1);
        try {
            take(attempt::decode_message(line));
        } catch (const Error& error) {  // the child's fault, not the recording's
            throw Error(ErrorCode::Unavailable, error.what());
        }
    }
    if (buffer.size() > attempt::kMaxLineBytes)
        throw Error(ErrorCode::Unavailable, "an attempt sent a line without an end");
}

// Stores progress and log until report_pending(), so that a child with many messages does not keep
// the catalog's only writer busy: the latest progress, and as much of the log as is kept.
void AttemptRunner::take(const attempt::AttemptMessage& message) {
    heard_ = Clock::now();
    if (const auto* progress = std::get_if<Progress>(&message)) {
        progress_ = *progress;
    } else if (const auto* log = std::get_if<attempt::LogText>(&message)) {
        if (num_log_bytes_ <= kMaxPendingLogBytes) log_ += log->text;
        num_log_bytes_ += log->text.size();
    } else if (const auto* stage = std::get_if<StageRun>(&message)) {
        report(*stage);
    } else if (const auto* measured = std::get_if<Measurement>(&message)) {
        measurement_ = *measured;
    } else if (const auto* truth = std::get_if<UnreadableTruth>(&message)) {
        unreadable_truth_ = *truth;
    } else {
        result_ = message;
    }
    report_pending(kReportEvery);
}

void AttemptRunner::report(const StageRun& stage) {
    if (++num_stages_ > kMaxReportedStages)
        throw Error(ErrorCode::Unavailable, "an attempt reported more stages than exist");
    report_pending(0ms);
    report([&] { return jobs_.report_stage(claim_.lease, stage); });
}

void AttemptRunner::report_pending(std::chrono::milliseconds at_least_after) {
    if (Clock::now() - reported_ < at_least_after || (!progress_ && log_.empty())) return;
    reported_ = Clock::now();
    if (const auto progress = std::exchange(progress_, std::nullopt))
        report([&] { return jobs_.report_progress(claim_.lease, *progress); });
    if (const std::string log = std::exchange(log_, ""); !log.empty())
        report([&] { return jobs_.append_log(claim_.lease, log); });
}

// Ignores a failed write, so that a short outage of the catalog does not end hours of work.
void AttemptRunner::report(const std::function<bool()>& write) {
    try {
        if (!write()) stop_ = Stop::LeaseLost;
    } catch (const std::exception& error) {
        log_warning(
            {{"event", "progress_not_written"}, {"job", claim_.job.id}, {"what", error.what()}});
    }
}

Stop AttemptRunner::reason_to_stop(const LeaseKeeper& keeper,
                                   const std::stop_token& stop,
                                   const ChildProcess& child) {
    if (keeper.lost()) return Stop::LeaseLost;
    if (keeper.cancel_requested()) return Stop::Cancelled;
    if (stop.stop_requested()) return Stop::ShuttingDown;
    if (Clock::now() - started_ > config_.deadline) return Stop::Deadline;
    if (Clock::now() - heard_ > config_.stall) return Stop::Stalled;
    if (Clock::now() - measured_ > kMeasureEvery) {
        measured_ = Clock::now();
        DiskRoom(config_).make(kRoomAhead_bytes);
        // A single file ends at this size.
        if (scratch_usage_bytes(folder(), child.pid()) - inputs_bytes_ >= scratch_bytes_)
            return Stop::ScratchFull;
    }
    return Stop::None;
}

// Kills the child at once if the lease is lost; otherwise it may first end by itself.
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
            log_warning({{"event", "lease_lost"},
                         {"job", claim_.job.id},
                         {"attempt", claim_.lease.attempt}});
            return;
        case Stop::Cancelled: return fail({ErrorCode::Cancelled, "cancelled"});
        case Stop::ScratchFull:
            return fail({.code = ErrorCode::OutOfSpace,
                         .message = "the attempt used more than its " +
                                    std::to_string(scratch_bytes_ >> 20) + " MiB of scratch space",
                         .remedy = "free space on the disk of the worker's scratch folder, or "
                                   "raise its limit with --scratch"});
        case Stop::ShuttingDown: persist([&] { return jobs_.release(claim_.lease); }); return;
        case Stop::Deadline:
            return fail({.code = ErrorCode::Unavailable,
                         .message = "the attempt took longer than its deadline",
                         .remedy = "choose a faster preset or a larger voxel_m, or give the worker "
                                   "more time"});
        case Stop::Stalled:
            return fail({.code = ErrorCode::Unavailable,
                         .message = "the attempt reported no progress for too long: it hangs",
                         .remedy = "if this repeats, report it with this dive"});
        case Stop::None: return;
    }
}

void AttemptRunner::conclude(const attempt::AttemptMessage& result,
                             const attempt::AttemptRequest& request) {
    if (const auto* failure = std::get_if<Failure>(&result))
        return measurement_.verdict ? fail_with_partial_result(*failure, request) : fail(*failure);
    if (const auto* intake = std::get_if<attempt::IntakeAnswer>(&result))
        return publish_intake(*intake, request);
    if (end_.exit_code != 0 || end_.signal != 0) return fail(failure_of(end_));
    const auto begun = Clock::now();
    const auto artifacts = on_own_storage([&] { return store_artifacts(request); });
    const std::chrono::duration<double> taken = Clock::now() - begun;
    const StageRun publish{.name = "publish", .seconds = taken.count()};
    if (!persist([&] { return jobs_.report_stage(claim_.lease, publish); })) return remove_blobs();
    if (!persist([&] { return jobs_.succeed(claim_.lease, artifacts, measurement_); }))
        remove_blobs();
}

void AttemptRunner::publish_intake(const attempt::IntakeAnswer& answer,
                                   const attempt::AttemptRequest& request) {
    storage::IntakeResult result{.findings = answer.findings,
                                 .name = answer.name,
                                 .site = answer.site,
                                 .rig = answer.rig,
                                 .tags = answer.tags,
                                 .notes = answer.notes,
                                 .position = answer.position,
                                 .content_sha256 = answer.content_sha256,
                                 .num_frames = answer.num_frames,
                                 .duration_s = answer.duration_s};
    if (answer.has_thumbnail) {
        result.thumbnail_blob = blob_prefix() + "thumbnail.jpg";
        on_own_storage(
            [&] { blobs_.put_file(result.thumbnail_blob, request.out / "thumbnail.jpg"); });
    }
    if (!persist([&] { return jobs_.finish_intake(claim_.lease, result); })) remove_blobs();
}

// Stores every file in the child's out folder, under keys of this attempt.
std::vector<Artifact> AttemptRunner::store_artifacts(const attempt::AttemptRequest& request) {
    auto artifacts = list_artifacts(request.out);
    for (Artifact& artifact : artifacts) {
        artifact.job_id = claim_.job.id;
        artifact.blob = blob_prefix() + artifact.name;
        blobs_.put_file(artifact.blob, request.out / artifact.name);
    }
    return artifacts;
}

void AttemptRunner::fail(const Failure& failure) {
    if (const auto fault = fault_of_worker(gate_, failure, is_to_blame())) return put_back(*fault);
    log_info({{"event", "attempt_failed"},
              {"job", claim_.job.id},
              {"attempt", claim_.lease.attempt},
              {"code", to_string(failure.code)},
              {"what", failure.message}});
    remove_blobs();
    remove_scratch();  // first, because the catalog may be on the same full disk
    persist([&] { return jobs_.fail(claim_.lease, failure, unreadable_truth_); });
}

// Returns whether the attempt has used most of the space or all of the time that it may use: then a
// full disk is no excuse.
bool AttemptRunner::is_to_blame() const {
    return stop_ == Stop::ScratchFull || stop_ == Stop::Deadline || stop_ == Stop::Stalled ||
           (scratch_bytes_ > 0 &&
            scratch_usage_bytes(folder(), kNoProcess) - inputs_bytes_ > scratch_bytes_ / 4 * 3);
}

// Returns the job to the queue without counting the attempt: not the job failed, but this worker.
void AttemptRunner::put_back(const Failure& failure) {
    log_warning({{"event", "attempt_put_back"},
                 {"job", claim_.job.id},
                 {"attempt", claim_.lease.attempt},
                 {"code", to_string(failure.code)},
                 {"what", failure.message}});
    remove_blobs();
    remove_scratch();
    persist([&] { return jobs_.return_to_queue(claim_.lease, failure); });
}

// Keeps what a reconstruction that is not usable has left: it shows why.
void AttemptRunner::fail_with_partial_result(const Failure& failure,
                                             const attempt::AttemptRequest& request) {
    log_info({{"event", "attempt_failed"},
              {"job", claim_.job.id},
              {"attempt", claim_.lease.attempt},
              {"code", to_string(failure.code)},
              {"what", failure.message}});
    const storage::PartialResult partial{on_own_storage([&] { return store_artifacts(request); }),
                                         measurement_};
    if (!persist([&] { return jobs_.fail(claim_.lease, failure, unreadable_truth_, partial); }))
        remove_blobs();
}

// Removes the blobs of this attempt, unless it succeeded or left a partial result: a commit may
// have reached the catalog although its answer was an error. Blobs that cannot be removed do no
// harm.
void AttemptRunner::remove_blobs() const {
    try {
        for (const Attempt& attempt : jobs_.attempts(claim_.job.id))
            if (attempt.number == claim_.lease.attempt && attempt.state == AttemptState::Succeeded)
                return;
        for (const Artifact& artifact : jobs_.artifacts(claim_.job.id))
            if (artifact.blob.starts_with(blob_prefix())) return;
        blobs_.remove_prefix(blob_prefix());
    } catch (const std::exception& error) {
        log_warning({{"event", "leftovers"}, {"job", claim_.job.id}, {"what", error.what()}});
    }
}

// Makes the last write of an attempt: if the catalog is unreachable or its disk full, retries for
// as long as the lease can last; after that the job may belong to another worker.
bool AttemptRunner::persist(const std::function<bool()>& write) const {
    for (const auto give_up = Clock::now() + config_.lease;;) {
        try {
            return write();
        } catch (const Error& error) {
            const bool may_pass =
                error.code() == ErrorCode::Unavailable || error.code() == ErrorCode::OutOfSpace;
            if (!may_pass || Clock::now() > give_up) throw;
            log_warning(
                {{"event", "result_not_written"}, {"job", claim_.job.id}, {"what", error.what()}});
        }
        std::this_thread::sleep_for(config_.poll_every);
    }
}

}  // namespace divemesh::runner
