#pragma once

#include <filesystem>
#include <utility>
#include <vector>

namespace divemesh::bench {

// The files of the left and the right image of each pair.
using PairFiles = std::vector<std::pair<std::filesystem::path, std::filesystem::path>>;

// Returns the image files of a dive's pairs, sorted by name.
PairFiles pair_files(const std::filesystem::path& dive);

}  // namespace divemesh::bench
