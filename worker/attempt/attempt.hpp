#pragma once

#include <filesystem>

namespace divemesh::attempt {

// Runs an attempt in the child process of a worker: executes the request file and reports to the
// parent over the pipe at kAttemptPipe. SIGTERM cancels: the next progress report throws
// Error{Cancelled}. It uses neither catalog nor blob store. Returns the exit code of the process;
// never throws.
int run_attempt(const std::filesystem::path& request_file);

}  // namespace divemesh::attempt
