#include "worker/color/thin_sightings.hpp"

#include <algorithm>
#include <tuple>

namespace divemesh::color {
namespace {

// Returns the sighting between its neighbours in range that lie nearest to each other.
std::vector<Sighting>::iterator least_missed(std::vector<Sighting>& by_range) {
    auto least = by_range.begin() + 1;
    for (auto middle = least; middle + 1 != by_range.end(); ++middle)
        if ((middle + 1)->range_m - (middle - 1)->range_m <
            (least + 1)->range_m - (least - 1)->range_m)
            least = middle;
    return least;
}

}  // namespace

void thin_sightings(std::vector<Sighting>& sightings, std::size_t num) {
    if (sightings.size() <= num || sightings.size() < 3) return;
    std::sort(sightings.begin(), sightings.end(), [](const Sighting& a, const Sighting& b) {
        return std::tie(a.range_m, a.keyframe) < std::tie(b.range_m, b.keyframe);
    });
    while (sightings.size() > std::max<std::size_t>(2, num))
        sightings.erase(least_missed(sightings));
    std::sort(sightings.begin(), sightings.end(), [](const Sighting& a, const Sighting& b) {
        return a.keyframe < b.keyframe;
    });
}

}  // namespace divemesh::color
