#pragma once

#include <cstddef>
#include <filesystem>
#include <map>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

namespace divemesh::sensor {

// Which dives the server has to get, on disk before anything follows from it: a dive is noted when
// it begins, so that one which the power cut short is sent as well, and once it is on the server
// before anything else is forgotten of it. Any thread.
class UploadLedger {
public:
    enum class State {
        Old,   // was there before the device was told to send its dives
        Open,  // is recorded, or was when the device stopped
        Over,  // is to be sent
        Sent,
    };
    struct Note {
        State state = State::Open;
        std::string
            sent;  // which bytes the server has of it: of the server and the archive; "": none
    };

    // What is in `file`; where that is damaged it begins anew, as if there were none.
    explicit UploadLedger(std::filesystem::path file);

    bool has_begun() const;  // there was a file, or begin() was called
    void begin(const std::vector<std::filesystem::path>& old_dives);
    std::optional<Note> find(const std::filesystem::path& dive) const;
    std::vector<std::filesystem::path> all(State state) const;
    // Keeps what was sent of it. A dive that is not there any more and owes nothing is forgotten.
    void note(const std::filesystem::path& dive, State state);
    void note_sent(const std::filesystem::path& dive, const std::string& sent);

    std::string trouble() const;  // "": what was noted is on disk

private:
    void save();

    std::filesystem::path file_;
    mutable std::mutex mutex_;
    bool has_begun_ = false;
    std::map<std::filesystem::path, Note> notes_;
    std::string trouble_;
};

}  // namespace divemesh::sensor
