#pragma once

#include <Eigen/Geometry>
#include <vector>

#include "worker/compare/change_map.hpp"
#include "worker/compare/change_noise.hpp"
#include "worker/stats/estimate.hpp"

namespace divemesh::compare {

// Connected ground that rose or sank beyond the level of detection.
struct ChangePatch {
    int number = 0;  // from 1 on, the largest volume first
    bool grown = false;
    stats::Estimate area_m2;    // seen from above
    stats::Estimate volume_m3;  // between both surfaces, positive
    Eigen::Vector2d center_m = Eigen::Vector2d::Zero();
    Eigen::AlignedBox2d box_m;
    double mean_change_m = 0.0;
    double largest_change_m = 0.0;
    double num_sigma = 1.96;  // standard deviations to either side of the volume
    double outline_m = 0.0;   // standard deviation of the mean change, of how the outline is known
    double hidden_m2 = 0.0;   // beside it, of ground that one dive did not see
};

struct ChangeTotal {
    stats::Estimate area_m2;
    stats::Estimate volume_m3;   // its upper bound holds what may be outside of the patches as well
    double undetected_m3 = 0.0;  // at most, outside of all patches
    std::size_t num_patches = 0;
};

struct Changes {
    std::vector<ChangePatch> patches;
    ChangeTotal grown;
    ChangeTotal lost;
    stats::Estimate rest_m3;  // rise less fall of the ground outside of all patches
    double rest_m2 = 0.0;
    ChangeNoise noise{std::vector<ChangeNoise::Step>{}};
    double beyond_share =
        0.0;         // of that ground: beyond its level of detection, in patches too small
    cv::Mat number;  // CV_32S: of the patch whose volume a cell belongs to, 0 none
};

struct PatchOptions {
    double least_area_m2 = 0.005;
    double core_area_m2 = 0.00125;  // that has to exceed the level for the whole ground
    double margin_m = 0.05;         // about the significant cells, that belongs to the volume
};

// Cells that are joined by sides or corners and changed the same way make a patch, when a part of
// them has changed by more than stable ground does anywhere: of all the pieces of `core_area_m2`
// that both dives saw, one in twenty comparisons would find one beyond that level (Bonferroni); a
// level of 95 % alone is exceeded by a twentieth of the ground. Its volume is
// summed over a margin too, where change fades out below the level of detection; its area is that
// of the significant cells with what they enclose, its outline known to half the margin.
// The volume's interval has the noise of a mean over that area, as measured on stable ground, and
// the registration's and the outline's error, which are the same for all patches of a total; and,
// patches being chosen for how much they seem to have changed, so many standard deviations that 95
// % of the chosen hold (false coverage rate; Benjamini and Yekutieli 2005). What changed by less
// than the level of detection is in no patch: a total's upper bound adds what all blocks of 0.15 m
// of the other ground rose (sank) by beyond what their noise alone shows.
Changes gather_changes(ChangeMap& map, const PatchOptions& options);

}  // namespace divemesh::compare
