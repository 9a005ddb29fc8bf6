#pragma once

#include <filesystem>

namespace divemesh::attempt {

// The child of a worker: does what the request file says and tells the parent over the pipe at
// kAttemptPipe. SIGTERM cancels: the next progress report throws Error{Cancelled}. Knows neither
// catalog nor blob store. Returns the exit code of the process; never throws.
int run_attempt(const std::filesystem::path& request_file);

}  // namespace divemesh::attempt
