#pragma once

#include <filesystem>
#include <optional>

#include "tests/bench/plan.hpp"

namespace divemesh::bench {

// Returns the folder of a dive: in the shared data, or in the cache, where a simulated dive is
// rendered once. Returns nullopt, and says why on stderr, if the shared data lack the dive or
// rendering fails.
std::optional<std::filesystem::path> dive_folder(const Dive& dive,
                                                 const std::filesystem::path& program,
                                                 const std::filesystem::path& cache);

// Copies a dive to `folder` without ground truth, reference mesh and known lengths, like a diver's
// recording. Copies the bytes, because a reader follows no link out of a dive.
void copy_without_truth(const std::filesystem::path& dive, const std::filesystem::path& folder);

}  // namespace divemesh::bench
