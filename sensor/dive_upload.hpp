#pragma once

#include <atomic>
#include <filesystem>
#include <functional>
#include <string>
#include <thread>

#include "api/client/rest_client.hpp"

namespace divemesh::sensor {

struct DiveUploadSettings {
    api::client::Account account;        // whose token may write dives, which a sensor's may not
    double max_bytes_per_s = 0.0;        // 0: as fast as it goes
    std::string job;                     // preset to reconstruct it with; "": none
    std::function<bool()> is_link_good;  // it waits for that; any thread
    std::function<void(const std::string& what)> on_event;  // for people; on its own thread
};

// Sends a dive that is over to the server, by an upload that goes on where it was cut. A thread of
// its own; the destructor ends it, and the next time it goes on.
class DiveUpload {
public:
    DiveUpload(std::filesystem::path dive, DiveUploadSettings settings);
    ~DiveUpload();
    DiveUpload(const DiveUpload&) = delete;
    DiveUpload& operator=(const DiveUpload&) = delete;

    bool is_done() const { return is_done_; }  // or will never be, which was told
    bool has_failed() const { return has_failed_; }

private:
    void run(const std::stop_token& stop);
    void send(const std::stop_token& stop);

    std::filesystem::path dive_;
    DiveUploadSettings settings_;
    std::atomic<bool> is_done_ = false;
    std::atomic<bool> has_failed_ = false;
    std::jthread thread_;  // last: it uses the others
};

}  // namespace divemesh::sensor
