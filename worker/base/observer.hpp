#pragma once

#include <cstdint>
#include <functional>
#include <string>

#include "schemas/error.hpp"
#include "schemas/job.hpp"

namespace divemesh::base {

// Receives the progress of a stage, which calls it at least every 200 ms of its work. It throws
// Error{Cancelled} to stop the stage; no step catches that. This is the only channel between the
// running pipeline and its surroundings.
using ProgressCallback = std::function<void(const Progress&)>;

inline void ignore_progress(const Progress&) {}

}  // namespace divemesh::base
