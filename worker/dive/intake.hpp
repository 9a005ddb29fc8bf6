#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "schemas/finding.hpp"
#include "worker/base/observer.hpp"

namespace divemesh::dive {

// What `divemesh validate` prints and an intake job answers.
struct IntakeReport {
    std::vector<Finding> findings;  // an error among them: refused
    std::string name;               // dive.json's, "" when it says none
    std::string site;
    std::string rig;
    std::vector<std::string> tags;
    std::string content_sha256;
    std::int64_t num_frames = 0;
    double duration_s = 0.0;
    std::string thumbnail_jpeg;  // bytes; "" when no picture decodes
};

// Opens the dive and every picture of it. Bad data is findings, never an exception; what throws is
// Error{Cancelled} and a broken machine.
IntakeReport examine_dive(const std::filesystem::path& path,
                          const std::filesystem::path& scratch,
                          const base::ProgressCallback& progress);

}  // namespace divemesh::dive
