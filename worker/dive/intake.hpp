#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "schemas/content_hash.hpp"
#include "schemas/finding.hpp"
#include "schemas/links.hpp"
#include "worker/base/observer.hpp"
#include "worker/types/geographic_position.hpp"

namespace divemesh::types {
class Recording;
}

namespace divemesh::dive {

// The result of `divemesh validate` and of an intake job.
struct IntakeReport {
    std::vector<Finding> findings;  // with an error among them the dive is refused
    std::string name;               // from dive.json, "" if missing
    std::string site;
    std::string rig;
    std::vector<std::string> tags;
    std::string notes;
    std::optional<types::GeographicPosition> position;
    ContentHash content_sha256;
    std::int64_t num_frames = 0;
    double duration_s = 0.0;
    std::string thumbnail_jpeg;  // bytes; "" if no image decodes
};

// A check that a layer above adds.
using RecordingCheck = std::function<std::vector<Finding>(const types::Recording& recording,
                                                          const base::ProgressCallback& progress)>;

// Opens the dive, decodes every image and, if nothing refuses the dive, runs `check`. Bad data is
// reported as findings, not thrown; it throws Error{Cancelled}, and errors of the machine such as a
// full disk.
IntakeReport examine_dive(const std::filesystem::path& path,
                          const std::filesystem::path& scratch,
                          const base::ProgressCallback& progress,
                          const RecordingCheck& check = {},
                          Links links = Links::LeaveOut);

}  // namespace divemesh::dive
