#pragma once

#include <filesystem>
#include <utility>
#include <vector>

namespace divemesh::bench {

// The files of the left and of the right pictures of a dive, in order; those of one pair have the
// same place in both.
using PairFiles = std::vector<std::pair<std::filesystem::path, std::filesystem::path>>;
PairFiles pair_files(const std::filesystem::path& dive);

}  // namespace divemesh::bench
