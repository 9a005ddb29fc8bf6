#include "worker/color/thin_sightings.hpp"

#include <gtest/gtest.h>

#include <algorithm>

namespace divemesh::color {
namespace {

bool by_keyframe(const Sighting& a, const Sighting& b) { return a.keyframe < b.keyframe; }
bool by_range(const Sighting& a, const Sighting& b) { return a.range_m < b.range_m; }

TEST(ThinSightings, KeepTheRangesOfADiverWhoStaysInOnePlaceForLong) {
    std::vector<Sighting> sightings;
    for (std::uint32_t i = 0; i < 90; ++i)  // stays at 2 m, then leaves and comes back
        sightings.push_back({.keyframe = i, .range_m = 2.0F + 1e-4F * static_cast<float>(i % 7)});
    for (std::uint32_t i = 90; i < 100; ++i)
        sightings.push_back({.keyframe = i, .range_m = 0.5F * static_cast<float>(100 - i)});
    thin_sightings(sightings, 16);
    ASSERT_EQ(sightings.size(), 16U);
    EXPECT_TRUE(std::is_sorted(sightings.begin(), sightings.end(), by_keyframe));
    EXPECT_EQ(std::min_element(sightings.begin(), sightings.end(), by_range)->range_m, 0.5F);
    EXPECT_EQ(std::max_element(sightings.begin(), sightings.end(), by_range)->range_m, 5.0F);
    EXPECT_GE(std::count_if(sightings.begin(),
                            sightings.end(),
                            [](const Sighting& sighting) { return sighting.keyframe >= 90; }),
              9);
}

TEST(ThinSightings, LeaveFewAsTheyAre) {
    std::vector<Sighting> sightings(4);
    thin_sightings(sightings, 4);
    EXPECT_EQ(sightings.size(), 4U);
    thin_sightings(sightings, 0);  // the ends always stay
    EXPECT_EQ(sightings.size(), 2U);
    std::vector<Sighting> none;
    thin_sightings(none, 3);
    EXPECT_TRUE(none.empty());
}

}  // namespace
}  // namespace divemesh::color
