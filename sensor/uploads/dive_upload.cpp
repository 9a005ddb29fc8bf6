#include "sensor/uploads/dive_upload.hpp"

#include <chrono>
#include <condition_variable>
#include <map>
#include <mutex>
#include <utility>

#include "api/client/dive_tar.hpp"
#include "api/client/tus_upload.hpp"
#include "schemas/error.hpp"

namespace divemesh::sensor {
namespace {

namespace client = api::client;

constexpr std::chrono::milliseconds kAssessmentScale{500};
constexpr std::chrono::milliseconds kStall{10'000};

void throw_if(const std::stop_token& stop) {
    if (stop.stop_requested()) throw Error(ErrorCode::Cancelled, "stopped");
}

void wait_for_link(const DiveUploadSettings& settings, const std::stop_token& stop) {
    std::mutex mutex;
    std::unique_lock lock(mutex);
    std::condition_variable_any never;
    std::chrono::milliseconds good{0};
    while (good < settings.good_for) {
        never.wait_for(lock, stop, kAssessmentScale, [] { return false; });
        throw_if(stop);
        good = settings.is_link_good() ? good + kAssessmentScale : std::chrono::milliseconds(0);
    }
}

}  // namespace

DiveUpload::DiveUpload(std::filesystem::path dive,
                       DiveUploadSettings settings,
                       UploadLedger& ledger)
    : dive_(std::move(dive)),
      settings_(std::move(settings)),
      ledger_(ledger),
      thread_([this](const std::stop_token& stop) { run(stop); }) {}

DiveUpload::~DiveUpload() {
    thread_.request_stop();
    thread_.join();
}

void DiveUpload::tell(const std::string& what) const {
    if (settings_.on_event) settings_.on_event(what);
}

void DiveUpload::run(const std::stop_token& stop) {
    try {
        wait_for_link(settings_, stop);
        tell("sending " + dive_.string());
        send(stop);
    } catch (const std::exception& error) {
        has_failed_ = true;
        tell(dive_.string() + " was not uploaded: " + error.what());
    }
    is_done_ = true;
}

void DiveUpload::send(const std::stop_token& stop) {
    client::DiveTar tar(dive_, Links::LeaveOut);
    const auto hashes = tar.hash([&](std::int64_t) { throw_if(stop); });
    const std::string name = settings_.account.server.url() + " " + hashes.archive_sha256;
    if (const auto known = ledger_.find(dive_); known && known->sent == name) {
        ledger_.note_sent(dive_, name);
        return tell(dive_.string() + " is already on the server");
    }
    std::map<std::string, std::string> metadata = {{"filename", dive_.filename().string() + ".tar"},
                                                   {"sha256", hashes.archive_sha256}};
    if (!hashes.content_sha256.empty()) metadata["dive"] = hashes.content_sha256;
    if (!settings_.job.empty()) metadata["job"] = settings_.job;
    client::TusObserver observer;
    observer.on_progress = [&](std::int64_t) { throw_if(stop); };
    observer.on_wait = [&](const Error&, std::chrono::milliseconds) { throw_if(stop); };
    client::TusSettings transfer;
    transfer.max_bytes_per_s = settings_.max_bytes_per_s;
    transfer.stall = kStall;
    const client::UploadState state(
        settings_.state_folder, settings_.account.server.url(), hashes.archive_sha256);
    const std::string upload =
        client::upload_by_tus(settings_.account, tar, metadata, state, observer, transfer);
    client::RestClient rest(settings_.account);
    client::Backoff backoff(std::chrono::milliseconds(0), observer.on_wait, stop);
    const auto dive = rest.post_once("/api/v1/dives",
                                     {{"upload_id", upload.substr(upload.rfind('/') + 1)}},
                                     backoff,
                                     client::hashing_timeout(tar.size_bytes()));
    // In this order: if the power fails in between, the dive is known to be sent.
    ledger_.note_sent(dive_, name);
    state.forget();
    tell(dive_.string() + " was uploaded as dive " + dive.value("id", ""));
}

}  // namespace divemesh::sensor
