#pragma once

#include <cstddef>
#include <filesystem>
#include <map>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

namespace divemesh::sensor {

// Which dives the server still has to get; each note is on disk before anything else follows from
// it. A dive is noted when it begins, so that one cut short by a power failure is sent as well; and
// once it is on the server, before other state of it is deleted. Thread-safe.
class UploadLedger {
public:
    enum class State {
        Old,   // from before uploads were switched on
        Open,  // is recorded, or was when the device stopped
        Over,  // to be sent
        Sent,
    };
    struct Note {
        State state = State::Open;
        std::string sent;  // server and archive of the bytes that the server has; "": no bytes
    };

    // Reads `file`; starts empty if that is damaged.
    explicit UploadLedger(std::filesystem::path file);

    bool has_begun() const;  // there was a file, or begin() was called
    void begin(const std::vector<std::filesystem::path>& old_dives);
    std::optional<Note> find(const std::filesystem::path& dive) const;
    std::vector<std::filesystem::path> all(State state) const;
    // Sets the state and keeps what was sent. Forgets a dive that no longer exists and needs no
    // upload.
    void note(const std::filesystem::path& dive, State state);
    void note_sent(const std::filesystem::path& dive, const std::string& sent);

    std::string trouble() const;  // "": all notes are on disk

private:
    void save();

    std::filesystem::path file_;
    mutable std::mutex mutex_;
    bool has_begun_ = false;
    std::map<std::filesystem::path, Note> notes_;
    std::string trouble_;
};

}  // namespace divemesh::sensor
