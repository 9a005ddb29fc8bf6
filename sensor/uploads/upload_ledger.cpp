#include "sensor/uploads/upload_ledger.hpp"

#include <array>
#include <fstream>
#include <nlohmann/json.hpp>
#include <system_error>
#include <utility>

#include "schemas/error.hpp"
#include "worker/base/atomic_file.hpp"

namespace divemesh::sensor {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using State = UploadLedger::State;

constexpr std::array<std::pair<State, const char*>, 4> kWords = {
    {{State::Old, "old"}, {State::Open, "open"}, {State::Over, "over"}, {State::Sent, "sent"}}};

std::optional<State> state_of(const std::string& word) {
    for (const auto& [state, name] : kWords)
        if (word == name) return state;
    return std::nullopt;
}

std::string word_of(State state) {
    for (const auto& [known, name] : kWords)
        if (known == state) return name;
    return "";
}

std::string text_at(const json& object, const char* name) {
    const auto found = object.find(name);
    return found != object.end() && found->is_string() ? found->get<std::string>() : "";
}

}  // namespace

UploadLedger::UploadLedger(fs::path file) : file_(std::move(file)) {
    std::ifstream stream(file_);
    const json notes = json::parse(stream, nullptr, false);
    if (!notes.is_object()) return;
    has_begun_ = true;
    for (const auto& [dive, note] : notes.items()) {
        if (!note.is_object()) continue;
        if (const auto state = state_of(text_at(note, "state")))
            notes_[dive] = {*state, text_at(note, "sent")};
    }
}

bool UploadLedger::has_begun() const {
    const std::lock_guard lock(mutex_);
    return has_begun_;
}

void UploadLedger::begin(const std::vector<fs::path>& old_dives) {
    const std::lock_guard lock(mutex_);
    has_begun_ = true;
    for (const fs::path& dive : old_dives) notes_[dive].state = State::Old;
    save();
}

std::optional<UploadLedger::Note> UploadLedger::find(const fs::path& dive) const {
    const std::lock_guard lock(mutex_);
    const auto found = notes_.find(dive);
    if (found == notes_.end()) return std::nullopt;
    return found->second;
}

std::vector<fs::path> UploadLedger::all(State state) const {
    const std::lock_guard lock(mutex_);
    std::vector<fs::path> dives;
    for (const auto& [dive, note] : notes_)
        if (note.state == state) dives.push_back(dive);
    return dives;
}

void UploadLedger::note(const fs::path& dive, State state) {
    const std::lock_guard lock(mutex_);
    notes_[dive].state = state;
    save();
}

void UploadLedger::note_sent(const fs::path& dive, const std::string& sent) {
    const std::lock_guard lock(mutex_);
    notes_[dive] = {State::Sent, sent};
    save();
}

std::string UploadLedger::trouble() const {
    const std::lock_guard lock(mutex_);
    return trouble_;
}

void UploadLedger::save() {
    std::erase_if(notes_, [](const auto& one) {
        std::error_code failure;
        const bool owes = one.second.state == State::Open || one.second.state == State::Over;
        return !owes && !fs::exists(one.first, failure) && !failure;
    });
    json all = json::object();
    for (const auto& [dive, note] : notes_)
        all[dive.string()] = {{"state", word_of(note.state)}, {"sent", note.sent}};
    try {
        std::error_code ignored;
        fs::create_directories(file_.parent_path(), ignored);
        base::write_file(file_, all.dump());
        trouble_.clear();
    } catch (const Error& error) {
        trouble_ = error.what();
    } catch (const json::exception&) {
        trouble_ = "the name of a dive is not UTF-8: rename it";
    }
}

}  // namespace divemesh::sensor
