#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace divemesh {

// checking until the intake job has read the dive, then ready or refused. It never changes after
// that.
enum class DiveState { Checking, Ready, Refused };

std::string_view to_string(DiveState state);
DiveState dive_state_from_string(std::string_view text);  // throws Error{InvalidArgument}

// Where a dive was, WGS 84.
struct DivePosition {
    double latitude_deg = 0.0;
    double longitude_deg = 0.0;
};

// One recording by one rig, as the catalog stores it. Name, site, rig, tags, notes and position are
// the recording's, or what people have edited. Times are unix milliseconds (wall clock).
struct Dive {
    std::string id;  // made by the server
    std::string project;
    DiveState state = DiveState::Checking;
    std::string name;  // from dive.json, otherwise the name of the uploaded file
    std::string site;
    std::string rig;  // from dive.json, like the site
    std::vector<std::string> tags;
    std::string notes;
    std::optional<DivePosition> position;
    // The recording's own values of what was edited, by the names of the fields.
    nlohmann::json recorded = nlohmann::json::object();
    std::string archive_sha256;  // of the bytes that were uploaded
    std::string content_sha256;  // same for zip and tar; "" until the client or intake sets it
    std::int64_t archive_bytes = 0;
    std::string blob;             // key of the archive in the blob store; not shown over HTTP
    std::int64_t num_frames = 0;  // 0 until intake
    double duration_s = 0.0;      // 0 until intake
    bool has_thumbnail = false;
    std::int64_t created_at_ms = 0;
    std::int64_t deleted_at_ms = 0;  // 0: not deleted
    std::int64_t expires_at_ms = 0;  // of a deleted dive: when it is removed for good
};

}  // namespace divemesh
