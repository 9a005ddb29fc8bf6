#include "sensor/uploads/dive_uploads.hpp"

#include <algorithm>
#include <system_error>
#include <utility>

namespace divemesh::sensor {

namespace fs = std::filesystem;
using State = UploadLedger::State;

DiveUploads::DiveUploads(const fs::path& folder,
                         DiveUploadSettings settings,
                         Clock::duration over_after)
    : ledger_(folder / "uploads.json"), settings_(std::move(settings)), over_after_(over_after) {
    settings_.state_folder = folder;
}

DiveUploads::~DiveUploads() = default;

void DiveUploads::scan(const RecordingSource& source, Clock::time_point now) {
    learn(source);
    const fs::path& open_dive = source.state().open_dive;
    if (!open_dive.empty()) {
        const auto known = ledger_.find(open_dive);
        if (!known || known->state != State::Open) ledger_.note(open_dive, State::Open);
    }
    close_silent(open_dive, now);
    send_next();
}

void DiveUploads::over(const fs::path& dive) {
    failed_.erase(dive);
    ledger_.note(dive, State::Over);
}

// At the first start all dives are old; later an unknown dive was recorded meanwhile.
void DiveUploads::learn(const RecordingSource& source) {
    const auto dives = source.dives();
    if (!dives) return;
    if (!ledger_.has_begun()) return ledger_.begin(*dives);
    for (const fs::path& dive : *dives)
        if (!ledger_.find(dive)) ledger_.note(dive, State::Open);
}

void DiveUploads::close_silent(const fs::path& open_dive, Clock::time_point now) {
    for (const fs::path& dive : ledger_.all(State::Open)) {
        auto& since = silent_since_.try_emplace(dive, now).first->second;
        if (dive == open_dive) since = now;
        std::error_code ignored;
        if (now - since < over_after_ && !fs::exists(dive / kRecordingDone, ignored)) continue;
        silent_since_.erase(dive);
        over(dive);
    }
}

std::optional<fs::path> DiveUploads::next() const {
    for (const fs::path& dive : ledger_.all(State::Over)) {
        std::error_code ignored;  // the disk that it is on may come back
        if (!failed_.contains(dive) && fs::exists(dive, ignored)) return dive;
    }
    return std::nullopt;
}

void DiveUploads::send_next() {
    if (upload_ && !upload_->is_done()) return;
    if (upload_ && upload_->has_failed()) failed_.insert(sending_);
    upload_.reset();
    const auto dive = next();
    if (!dive) return;
    sending_ = *dive;
    upload_ = std::make_unique<DiveUpload>(*dive, settings_, ledger_);
}

bool DiveUploads::is_idle() const { return !upload_ && !next(); }

bool DiveUploads::has_failed() const { return !failed_.empty(); }

}  // namespace divemesh::sensor
