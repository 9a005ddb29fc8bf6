#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "schemas/finding.hpp"
#include "worker/base/observer.hpp"

namespace divemesh::dive {

// The result of `divemesh validate` and of an intake job.
struct IntakeReport {
    std::vector<Finding> findings;  // with an error among them the dive is refused
    std::string name;               // from dive.json, "" if missing
    std::string site;
    std::string rig;
    std::vector<std::string> tags;
    std::string content_sha256;
    std::int64_t num_frames = 0;
    double duration_s = 0.0;
    std::string thumbnail_jpeg;  // bytes; "" if no image decodes
};

// Opens the dive and decodes every image. Bad data is reported as findings, not thrown; it throws
// Error{Cancelled}, and errors of the machine such as a full disk.
IntakeReport examine_dive(const std::filesystem::path& path,
                          const std::filesystem::path& scratch,
                          const base::ProgressCallback& progress);

}  // namespace divemesh::dive
