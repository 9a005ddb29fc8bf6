#pragma once

#include <filesystem>
#include <optional>

#include "tests/bench/plan.hpp"

namespace divemesh::bench {

// Where a dive lies: the shared data, or the cache, into which a simulated one is rendered once.
// Nothing when the shared data do not hold it or it could not be rendered; stderr says which.
std::optional<std::filesystem::path> dive_folder(const Dive& dive,
                                                 const std::filesystem::path& program,
                                                 const std::filesystem::path& cache);

// A dive as divers bring it: a copy in `folder` of all but ground truth, reference mesh and known
// lengths. A reader follows no link out of a dive, so it has to be one.
void copy_without_truth(const std::filesystem::path& dive, const std::filesystem::path& folder);

}  // namespace divemesh::bench
