#pragma once

#include <deque>
#include <filesystem>
#include <optional>
#include <string>

namespace divemesh::sensor {

// The state of a command: begun, done, failed, refused, expired.
struct CommandNote {
    std::string id;
    std::string state;
    std::string detail;
};

// The last commands, on disk before they are carried out, so that a repeated command is recognised,
// also after a restart. Begun without an end means that the power failed while it was carried out.
class CommandJournal {
public:
    static constexpr std::size_t kMaxNotes = 256;

    explicit CommandJournal(std::filesystem::path file);

    std::optional<CommandNote> find(const std::string& id) const;
    // Returns false if the note is in memory but not on disk.
    bool note(const CommandNote& note);

private:
    std::filesystem::path file_;
    std::deque<CommandNote> notes_;
};

}  // namespace divemesh::sensor
