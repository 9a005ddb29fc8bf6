#include "sensor/dive_upload.hpp"

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

constexpr std::chrono::seconds kLook{1};
constexpr int kGoodLooks = 5;  // in a row, before the link is believed
constexpr std::chrono::milliseconds kStall{10'000};

void throw_if(const std::stop_token& stop) {
    if (stop.stop_requested()) throw Error(ErrorCode::Cancelled, "stopped");
}

void wait_for_link(const std::function<bool()>& is_good, const std::stop_token& stop) {
    std::mutex mutex;
    std::unique_lock lock(mutex);
    std::condition_variable_any never;
    for (int num_good = 0; num_good < kGoodLooks; num_good = is_good() ? num_good + 1 : 0) {
        never.wait_for(lock, stop, kLook, [] { return false; });
        throw_if(stop);
    }
}

}  // namespace

DiveUpload::DiveUpload(std::filesystem::path dive, DiveUploadSettings settings)
    : dive_(std::move(dive)),
      settings_(std::move(settings)),
      thread_([this](const std::stop_token& stop) { run(stop); }) {}

DiveUpload::~DiveUpload() {
    thread_.request_stop();
    thread_.join();
}

void DiveUpload::run(const std::stop_token& stop) {
    try {
        wait_for_link(settings_.is_link_good, stop);
        settings_.on_event("sending " + dive_.string());
        send(stop);
    } catch (const std::exception& error) {
        has_failed_ = true;
        settings_.on_event(dive_.string() + " is not sent: " + error.what());
    }
    is_done_ = true;
}

void DiveUpload::send(const std::stop_token& stop) {
    client::DiveTar tar(dive_);
    const auto hashes = tar.hash([&](std::int64_t) { throw_if(stop); });
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
        client::default_state_folder(), settings_.account.server.url(), hashes.archive_sha256);
    const std::string upload =
        client::upload_by_tus(settings_.account, tar, metadata, state, observer, transfer);
    client::RestClient rest(settings_.account);
    client::Backoff backoff(std::chrono::milliseconds(0), observer.on_wait, stop);
    const auto dive = rest.post_once("/api/v1/dives",
                                     {{"upload_id", upload.substr(upload.rfind('/') + 1)}},
                                     backoff,
                                     client::hashing_patience(tar.size_bytes()));
    state.forget();
    settings_.on_event(dive_.string() + " is dive " + dive.value("id", "") + " on the server");
}

}  // namespace divemesh::sensor
