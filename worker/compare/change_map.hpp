#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <opencv2/core/mat.hpp>
#include <optional>
#include <vector>

#include "worker/compare/free_space.hpp"
#include "worker/compare/m3c2.hpp"
#include "worker/compare/point_to_plane_icp.hpp"
#include "worker/compare/surface_raster.hpp"

namespace divemesh::compare {

// What two dives show of one cell of the ground.
enum class CellState : std::uint8_t {
    Unseen,  // by both dives
    OnlyA,
    OnlyB,
    Stable,  // seen by both; no change beyond the level of detection
    Grown,
    Lost,
    Hidden,  // apparent change, but one dive did not look through the other's surface
};

// The change of each cell of the ground, seen from above, in a's frame.
struct ChangeMap {
    RasterGrid grid;
    cv::Mat state;           // CV_8U, CellState
    cv::Mat change_m;        // CV_32F, height of b over a; NaN unless both dives saw the cell
    cv::Mat sigma_m;         // CV_32F, of `change_m` without the co-registration's part
    cv::Mat registration_m;  // CV_32F, standard deviation of that part
    cv::Mat later_surface;   // CV_32FC3: slopes of b's surface along x and y, and its height, m
    // Error of the co-registration: a small rotation (rad) and shift (m) of b about the pivot.
    Eigen::Vector3d pivot = Eigen::Vector3d::Zero();
    Matrix6d registration_covariance = Matrix6d::Zero();

    // Returns by how much a rotation and a shift of b change a cell, per rad and m. The error of
    // the co-registration is one motion of all cells, so those of a sum are added with their signs.
    Vector6d change_by_motion(int row, int column) const;
    // Returns the standard deviation, by the co-registration, of a cell or of a sum over cells.
    double registration_sigma(const Vector6d& by_motion) const {
        return std::sqrt(std::max(0.0, by_motion.dot(registration_covariance * by_motion)));
    }
    CellState at(int row, int column) const {
        return static_cast<CellState>(state.at<std::uint8_t>(row, column));
    }
    double area_m2(CellState wanted) const;
};

// One dive's surface in a's frame, with its measurements.
struct Surveyed {
    const types::Mesh& mesh;
    const std::vector<M3c2Distance>& distances;  // of its vertices
    const std::optional<Views>& views;           // into this frame; nullopt: not checked
};

struct MapOptions {
    RasterGrid grid;
    double scale_m = 0.05;  // over which the scatter of ground of a kind is taken
    double reach_m = 0.5;   // of the M3C2 distances; larger changes are vertical differences alone
    int num_threads = 0;
};

// Returns the map of changes. A cell has changed if three conditions hold: the vertical difference
// exceeds its own level of detection (the scatter of such ground over `scale_m`: scale_by_scatter);
// the M3C2 distances there, one from each surface, confirm it; and the dive that lacks the higher
// surface looked through it at the ground behind. Distances confirm a change if one of them at
// least is known, and each that is known is significant with the same sign. With neither known, no
// change is detected, unless it is larger than the distances reach.
ChangeMap map_changes(const Surveyed& a,
                      const Surveyed& b,
                      const CoRegistration& registration,
                      const MapOptions& options);

}  // namespace divemesh::compare
