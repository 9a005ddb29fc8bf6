#pragma once

#include <Eigen/Geometry>
#include <vector>

#include "worker/compare/change_map.hpp"
#include "worker/compare/change_noise.hpp"
#include "worker/stats/distributions.hpp"
#include "worker/stats/estimate.hpp"

namespace divemesh::compare {

// Connected ground that rose or sank beyond the level of detection. The interval of its volume
// contains the noise of a mean over its area, as measured on stable ground, and the errors of the
// co-registration and the outline. Patches are chosen by their apparent change, so `num_sigma` is
// such that 95 % of the chosen intervals hold (false coverage rate; Benjamini and Yekutieli 2005).
struct ChangePatch {
    int number = 0;  // from 1 on, in order of decreasing volume
    bool grown = false;
    stats::Estimate area_m2;    // seen from above
    stats::Estimate volume_m3;  // between both surfaces, positive
    Eigen::Vector2d center_m = Eigen::Vector2d::Zero();
    Eigen::AlignedBox2d box_m;
    double mean_change_m = 0.0;
    double largest_change_m = 0.0;
    double num_sigma = stats::kNormal975;  // standard deviations on either side of the volume
    double outline_m = 0.0;  // standard deviation of the mean change, from the uncertain outline
    double hidden_m2 = 0.0;  // area beside it that one dive did not see
};

// All patches of one sign together. They share the errors of the co-registration and the outline.
// Change below the level of detection is in no patch. So the upper bound of the volume adds the
// rise (fall) of all blocks of 0.15 m of the other ground beyond their noise.
struct ChangeTotal {
    stats::Estimate area_m2;
    stats::Estimate volume_m3;   // the upper bound includes what may be outside the patches
    double undetected_m3 = 0.0;  // upper bound, outside all patches
    std::size_t num_patches = 0;
};

// The changes between two dives.
struct Changes {
    std::vector<ChangePatch> patches;
    ChangeTotal grown;
    ChangeTotal lost;
    stats::Estimate rest_m3;  // rise minus fall of the ground outside all patches
    double rest_m2 = 0.0;
    ChangeNoise noise{std::vector<ChangeNoise::Step>{}};
    double beyond_share =
        0.0;         // of that ground: share beyond its level of detection, in patches too small
    cv::Mat number;  // CV_32S: the patch to whose volume a cell belongs, 0: no patch
};

struct PatchOptions {
    double least_area_m2 = 0.005;
    double core_area_m2 = 0.00125;  // must exceed the level that holds for the whole ground
    double margin_m = 0.05;         // around the significant cells, included in the volume
};

// Gathers changed cells into patches. Cells that touch by sides or corners and changed the same way
// make a patch if a core of them, of `core_area_m2`, has changed beyond its level. The level of a
// core is such that stable ground exceeds it anywhere in only one comparison of twenty
// (Bonferroni). A level of 95 % would be exceeded by a twentieth of the ground. The volume also
// includes a margin, where change fades out below the level of detection. The area is that of the
// significant cells and the cells that they enclose; its outline is known to half the margin.
Changes gather_changes(ChangeMap& map, const PatchOptions& options);

}  // namespace divemesh::compare
