#pragma once

#include <deque>
#include <filesystem>
#include <optional>
#include <string>

namespace divemesh::sensor {

// What became of a command. State: begun, done, failed, refused, expired.
struct CommandNote {
    std::string id;
    std::string state;
    std::string detail;
};

// The last commands that came, on disk before they are carried out: what comes a second time, also
// after a restart, is known. Begun and not ended: the power went while it was carried out.
class CommandJournal {
public:
    static constexpr std::size_t kMaxNotes = 256;

    explicit CommandJournal(std::filesystem::path file);

    std::optional<CommandNote> find(const std::string& id) const;
    // False: it is remembered, but not on disk.
    bool note(const CommandNote& note);

private:
    std::filesystem::path file_;
    std::deque<CommandNote> notes_;
};

}  // namespace divemesh::sensor
