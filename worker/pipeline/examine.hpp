#pragma once

#include <filesystem>

#include "schemas/links.hpp"
#include "worker/base/observer.hpp"
#include "worker/dive/intake.hpp"

namespace divemesh::pipeline {

// Examines a dive, or a recording as the dive that it is turned into, as intake does: its tables
// and every image (dive::examine_dive()), and its cameras against each other.
dive::IntakeReport examine(const std::filesystem::path& path,
                           const std::filesystem::path& scratch,
                           const base::ProgressCallback& progress,
                           Links links = Links::LeaveOut);

}  // namespace divemesh::pipeline
