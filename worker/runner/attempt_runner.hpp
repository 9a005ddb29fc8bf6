#pragma once

#include <chrono>
#include <filesystem>
#include <functional>
#include <optional>
#include <stop_token>
#include <string>
#include <vector>

#include "storage/blob_store.hpp"
#include "storage/job_store.hpp"
#include "worker/attempt/attempt_protocol.hpp"
#include "worker/runner/child_process.hpp"
#include "worker/runner/job_runner.hpp"
#include "worker/runner/lease_keeper.hpp"
#include "worker/runner/worker_gate.hpp"

namespace divemesh::runner {

// Why the parent ends a child early.
enum class Stop { None, LeaseLost, Cancelled, Deadline, Stalled, ScratchFull, ShuttingDown };

// Runs one attempt, from its claim to its end in the catalog. All its writes carry the lease.
class AttemptRunner {
public:
    AttemptRunner(const WorkerConfig& config,
                  storage::JobStore& jobs,
                  storage::BlobStore& blobs,
                  WorkerGate& gate,
                  storage::Claim claim)
        : config_(config), jobs_(jobs), blobs_(blobs), gate_(gate), claim_(std::move(claim)) {}
    ~AttemptRunner() { remove_scratch(); }
    AttemptRunner(const AttemptRunner&) = delete;
    AttemptRunner& operator=(const AttemptRunner&) = delete;

    void run(const std::stop_token& stop);

private:
    using Clock = std::chrono::steady_clock;

    attempt::AttemptRequest write_request() const;
    std::filesystem::path fetch_dive() const;
    void fetch_inputs(attempt::AttemptRequest& request) const;
    void fetch_reconstruction(const std::vector<Artifact>& artifacts,
                              const std::filesystem::path& into) const;
    std::int64_t scratch_share() const;
    ProcessLimits limits();
    void supervise(const LeaseKeeper& keeper, const std::stop_token& stop);
    void read_lines(std::string& buffer);
    void take(const attempt::AttemptMessage& message);
    void report(const StageRun& stage);
    void report_pending(std::chrono::milliseconds at_least_after);
    void report(const std::function<bool()>& write);
    Stop reason_to_stop(const LeaseKeeper& keeper,
                        const std::stop_token& stop,
                        const ChildProcess& child);
    void end_child(ChildProcess& child);
    void conclude_stopped();
    void conclude(const attempt::AttemptMessage& result, const attempt::AttemptRequest& request);
    void publish_intake(const attempt::IntakeAnswer& answer,
                        const attempt::AttemptRequest& request);
    std::vector<Artifact> store_artifacts(const attempt::AttemptRequest& request);
    void fail(const Failure& failure);
    void put_back(const Failure& failure);
    bool is_to_blame() const;
    void remove_scratch() const;
    void fail_with_partial_result(const Failure& failure, const attempt::AttemptRequest& request);
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
    WorkerGate& gate_;
    storage::Claim claim_;
    Clock::time_point started_ = Clock::now();
    Clock::time_point heard_ = Clock::now();     // last message from the child
    Clock::time_point measured_ = Clock::now();  // last measurement of the scratch folder
    std::int64_t inputs_bytes_ = 0;              // of what was fetched into the scratch folder
    std::int64_t scratch_bytes_ = 0;             // limit for the scratch folder beside them
    Stop stop_ = Stop::None;
    std::optional<Clock::time_point> asked_to_end_;
    std::optional<attempt::AttemptMessage> result_;
    Measurement measurement_;
    std::optional<UnreadableTruth> unreadable_truth_;
    std::optional<Progress> progress_;  // not yet in the catalog
    std::string log_;                   // not yet in the catalog
    Clock::time_point reported_ = {};
    std::size_t num_log_bytes_ = 0;  // in total
    int num_stages_ = 0;
    ProcessEnd end_;
};

}  // namespace divemesh::runner
