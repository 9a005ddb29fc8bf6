#pragma once

#include <atomic>
#include <chrono>
#include <filesystem>
#include <functional>
#include <string>
#include <thread>

#include "api/client/rest_client.hpp"
#include "sensor/uploads/upload_ledger.hpp"

namespace divemesh::sensor {

struct DiveUploadSettings {
    api::client::Account account;        // its token may write dives, which a sensor's may not
    double max_bytes_per_s = 0.0;        // 0: no limit
    std::string job;                     // preset of the reconstruction; "": no reconstruction
    std::filesystem::path state_folder;  // for the progress of the upload
    std::function<bool()> is_link_good;  // the upload waits for it; called on any thread
    std::chrono::milliseconds good_for{5'000};              // before the upload starts
    std::function<void(const std::string& what)> on_event;  // readable; on its own thread
};

// Sends a finished dive to the server by a resumable upload, and records when the server has it.
// Does not send again what the server has. It has its own thread; the destructor ends it, and the
// next run resumes.
class DiveUpload {
public:
    DiveUpload(std::filesystem::path dive, DiveUploadSettings settings, UploadLedger& ledger);
    ~DiveUpload();
    DiveUpload(const DiveUpload&) = delete;
    DiveUpload& operator=(const DiveUpload&) = delete;

    bool is_done() const { return is_done_; }  // or given up for good, with an event
    bool has_failed() const { return has_failed_; }

private:
    void run(const std::stop_token& stop);
    void send(const std::stop_token& stop);
    void tell(const std::string& what) const;

    std::filesystem::path dive_;
    DiveUploadSettings settings_;
    UploadLedger& ledger_;
    std::atomic<bool> is_done_ = false;
    std::atomic<bool> has_failed_ = false;
    std::jthread thread_;  // last: it uses the others
};

}  // namespace divemesh::sensor
