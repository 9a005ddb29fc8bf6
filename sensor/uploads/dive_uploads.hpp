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

// Sends every dive that is over to the server, one after the other, whatever happened since it
// began: also one that ended when the agent was not running. What was there before the first start
// is not sent. One thread.
class DiveUploads {
public:
    // The ledger, and how far an upload has come, are kept in `folder`. A dive that was open at the
    // last stop is over when it has not grown for `over_after`.
    DiveUploads(const std::filesystem::path& folder,
                DiveUploadSettings settings,
                Clock::duration over_after);
    ~DiveUploads();

    // After each update() of the source.
    void look(const RecordingSource& source, Clock::time_point now);
    void over(const std::filesystem::path& dive);  // at once

    bool is_idle() const;     // nothing is under way, and nothing waits for it
    bool has_failed() const;  // of the dives that were tried since the start
    std::string trouble() const { return ledger_.trouble(); }

private:
    void learn(const RecordingSource& source);
    void close_silent(const std::filesystem::path& open_dive, Clock::time_point now);
    void send_next();
    std::optional<std::filesystem::path> next() const;

    UploadLedger ledger_;
    DiveUploadSettings settings_;
    Clock::duration over_after_;
    std::map<std::filesystem::path, Clock::time_point> silent_since_;  // of the open ones
    std::set<std::filesystem::path> failed_;  // tried again at the next start
    std::filesystem::path sending_;
    std::unique_ptr<DiveUpload> upload_;  // last: it uses the ledger
};

}  // namespace divemesh::sensor
