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
    api::client::Account account;        // whose token may write dives, which a sensor's may not
    double max_bytes_per_s = 0.0;        // 0: as fast as it goes
    std::string job;                     // preset to reconstruct it with; "": none
    std::filesystem::path state_folder;  // where it keeps how far it has come
    std::function<bool()> is_link_good;  // it waits for that; any thread
    std::chrono::milliseconds good_for{5'000};              // before the link is believed
    std::function<void(const std::string& what)> on_event;  // for people; on its own thread
};

// Sends a dive that is over to the server, by an upload that goes on where it was cut, and notes
// that the server has it. What it has already is not sent again. A thread of its own; the
// destructor ends it, and the next time it goes on.
class DiveUpload {
public:
    DiveUpload(std::filesystem::path dive, DiveUploadSettings settings, UploadLedger& ledger);
    ~DiveUpload();
    DiveUpload(const DiveUpload&) = delete;
    DiveUpload& operator=(const DiveUpload&) = delete;

    bool is_done() const { return is_done_; }  // or will never be, which was told
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
