#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <string>
#include <vector>

#include "worker/compare/marker_positions.hpp"
#include "worker/types/mesh.hpp"

namespace divemesh::compare {

// Where b could lie in a's frame, before surfaces are fitted to each other. Both worlds have z up;
// heading and origin are those of each dive's first pose, so that nothing is known of them.
struct CoarseAlignment {
    Eigen::Isometry3d T_a_b = Eigen::Isometry3d::Identity();
    std::string method;
    double score = 0.0;  // the more the better, within a method
};

// Markers that both dives know the place of: Horn (1987) over the middles of those with the same
// family and id, weighted alike; those that end more than 0.1 m apart are left out. Nothing when
// fewer than three are shared, or all lie on a line. The score is their number.
std::vector<CoarseAlignment> align_by_markers(const std::vector<MarkerPosition>& a,
                                              const std::vector<MarkerPosition>& b);

// Features (SIFT, Lowe 2004) of the views from above, matched, with the heights below them: 3D
// pairs, of which RANSAC over turn about the vertical and shift chooses, and Horn (1987) makes the
// pose. Nothing when fewer than 12 pairs agree. The score is their number.
std::vector<CoarseAlignment> align_by_features(const types::Mesh& a,
                                               const types::Mesh& b,
                                               std::uint64_t seed);

// Heights on a coarse grid: normalised correlation of what both saw (Padfield 2012, by FFT) at
// every shift and, four degrees apart, every heading. The best five that differ by more than 0.5 m
// or 12 degrees; the score is the correlation.
std::vector<CoarseAlignment> align_by_heights(const types::Mesh& a,
                                              const types::Mesh& b,
                                              int num_threads);

}  // namespace divemesh::compare
