#pragma once

#include <filesystem>
#include <map>
#include <memory>
#include <set>
#include <string>

#include "sensor/recording/recording_source.hpp"
#include "sensor/uploads/dive_upload.hpp"
#include "sensor/uploads/upload_ledger.hpp"

namespace divemesh::sensor {

// Sends every finished dive to the server, one after the other, also one that ended while the agent
// was not running. Dives from before the first start are not sent. Use it from one thread.
class DiveUploads {
public:
    // The ledger and the progress of uploads are in `folder`. A dive that was open at the last stop
    // counts as finished when it has not grown for `over_after`.
    DiveUploads(const std::filesystem::path& folder,
                DiveUploadSettings settings,
                Clock::duration over_after);
    ~DiveUploads();

    // Call it after each update() of the source.
    void scan(const RecordingSource& source, Clock::time_point now);
    void over(const std::filesystem::path& dive);  // sends it without waiting for `over_after`

    bool is_idle() const;     // no upload is under way or waiting
    bool has_failed() const;  // of the dives tried since the start
    std::string trouble() const { return ledger_.trouble(); }

private:
    void learn(const RecordingSource& source);
    void close_silent(const std::filesystem::path& open_dive, Clock::time_point now);
    void send_next();
    std::optional<std::filesystem::path> next() const;

    UploadLedger ledger_;
    DiveUploadSettings settings_;
    Clock::duration over_after_;
    std::map<std::filesystem::path, Clock::time_point> silent_since_;  // of the open dives
    std::set<std::filesystem::path> failed_;                           // retried at the next start
    std::filesystem::path sending_;
    std::unique_ptr<DiveUpload> upload_;  // last: it uses the ledger
};

}  // namespace divemesh::sensor
