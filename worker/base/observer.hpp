#pragma once

#include <cstdint>
#include <functional>
#include <string>

#include "schemas/error.hpp"
#include "schemas/job.hpp"

namespace divemesh::base {

// Progress out, cancellation in: the only way the pipeline and the world around it talk while it
// works. A stage calls report() at least every 200 ms of its work. The callback throws
// Error{Cancelled} to stop; no step catches that.
using ProgressCallback = std::function<void(const Progress&)>;

inline void ignore_progress(const Progress&) {}

}  // namespace divemesh::base
