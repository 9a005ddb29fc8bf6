#include "sensor/commands/command_journal.hpp"

#include <algorithm>
#include <fstream>
#include <nlohmann/json.hpp>
#include <system_error>

#include "schemas/error.hpp"
#include "worker/base/atomic_file.hpp"

namespace divemesh::sensor {

using nlohmann::json;

CommandJournal::CommandJournal(std::filesystem::path file) : file_(std::move(file)) {
    std::ifstream stream(file_);
    const json notes = json::parse(stream, nullptr, false);
    if (!notes.is_array()) return;
    for (const json& note : notes)
        if (note.is_object() && note.contains("id") && note["id"].is_string())
            notes_.push_back({note["id"], note.value("state", "begun"), note.value("detail", "")});
}

std::optional<CommandNote> CommandJournal::find(const std::string& id) const {
    const auto found = std::find_if(
        notes_.begin(), notes_.end(), [&](const CommandNote& note) { return note.id == id; });
    if (found == notes_.end()) return std::nullopt;
    return *found;
}

bool CommandJournal::note(const CommandNote& note) {
    std::erase_if(notes_, [&](const CommandNote& known) { return known.id == note.id; });
    notes_.push_back(note);
    if (notes_.size() > kMaxNotes) notes_.pop_front();
    json all = json::array();
    for (const CommandNote& one : notes_)
        all.push_back({{"id", one.id}, {"state", one.state}, {"detail", one.detail}});
    try {
        std::error_code ignored;
        std::filesystem::create_directories(file_.parent_path(), ignored);
        base::write_file(file_, all.dump(-1, ' ', false, json::error_handler_t::replace));
        return true;
    } catch (const Error&) {
        return false;
    }
}

}  // namespace divemesh::sensor
