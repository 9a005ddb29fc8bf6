#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <string>
#include <vector>

#include "worker/compare/marker_positions.hpp"
#include "worker/types/mesh.hpp"

namespace divemesh::compare {

// A possible pose of b in a's frame, before surfaces are aligned. Both worlds have z up. Heading
// and origin are those of each dive's first pose, so they are unknown.
struct CoarseAlignment {
    Eigen::Isometry3d T_a_b = Eigen::Isometry3d::Identity();
    std::string method;
    double score = 0.0;  // higher is better, within a method
};

// Aligns by markers that both dives have located: Horn (1987) over the centres of those with the
// same family and id, with equal weights. Markers that end more than 0.1 m apart are left out.
// Returns an empty list if fewer than three are shared, or all lie on a line. The score is their
// number.
std::vector<CoarseAlignment> align_by_markers(const std::vector<MarkerPosition>& a,
                                              const std::vector<MarkerPosition>& b);

// Aligns by features (SIFT, Lowe 2004) of the images from above, matched, with the heights below
// them: 3D pairs, from which RANSAC over heading and shift selects inliers, and Horn (1987)
// computes the pose. Returns an empty list if fewer than 12 pairs are inliers. The score is their
// number.
std::vector<CoarseAlignment> align_by_features(const types::Mesh& a,
                                               const types::Mesh& b,
                                               std::uint64_t seed);

// Aligns by heights on a coarse grid: normalised correlation of the ground that both saw (Padfield
// 2012, by FFT) at every shift and at headings four degrees apart. Returns the best five that
// differ by more than 0.5 m or 12 degrees; the score is the correlation.
std::vector<CoarseAlignment> align_by_heights(const types::Mesh& a,
                                              const types::Mesh& b,
                                              int num_threads);

}  // namespace divemesh::compare
