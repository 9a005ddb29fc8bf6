#include "tests/bench/images.hpp"

#include <algorithm>

namespace divemesh::bench {
namespace {

namespace fs = std::filesystem;

std::vector<fs::path> images_in(const fs::path& folder) {
    std::vector<fs::path> files;
    for (const auto& entry : fs::directory_iterator(folder)) files.push_back(entry.path());
    std::sort(files.begin(), files.end());
    return files;
}

}  // namespace

PairFiles pair_files(const fs::path& dive) {
    const fs::path mav0 = fs::exists(dive / "mav0") ? dive / "mav0" : dive;
    const auto left = images_in(mav0 / "cam0" / "data");
    const auto right = images_in(mav0 / "cam1" / "data");
    PairFiles pairs;
    for (std::size_t i = 0; i < std::min(left.size(), right.size()); ++i)
        pairs.emplace_back(left[i], right[i]);
    return pairs;
}

}  // namespace divemesh::bench
