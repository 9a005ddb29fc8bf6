#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "worker/types/path_uncertainty.hpp"

namespace divemesh::reef {

// Options of measuring areas. Lengths are in m.
struct MeasureOptions {
    std::vector<double> spacings_m = {0.01, 0.02, 0.05, 0.10, 0.25, 0.50};  // multiples of 1 cm
    // Min share of an area that must have been seen. The second is for heights and volumes, which a
    // single stone in unseen ground could change.
    double min_coverage = 0.5;
    double min_coverage_of_extremes = 0.9;

    // The following give the resolution of the surface. A disparity is computed from a support of
    // pixels: detail smaller than that at the range of the ground is not in the mesh, and the error
    // within one window is shared. Without cameras the mesh counts as fine as its triangles.
    std::vector<Eigen::Vector3d> camera_positions_world;
    double focal_px = 0.0;       // of the images in which the surface was matched
    double support_px = 15.0;    // census signature of 9 px, refined over windows of 7 px
    double window_px = 7.0;      // over which noise is shared
    double min_detail_m = 0.0;   // two voxels
    bool is_simplified = false;  // the mesh: it has no detail finer than two triangle sides

    double sigma_m = 0.0;         // of the vertices if the mesh has none
    double sigma_shared_m = 0.0;  // by which poses shift a whole area along its normal
    double scale_sigma = types::kCalibrationSigma;  // of all lengths, relative
    double noise_share = 1.0;            // max share of the stated local sigma that is present
    double sigma_relative_error = 0.25;  // relative error of sigma itself, one standard deviation
    double correlation_length_m = 0.0;   // of the noise; 0: of window_px, or two triangle sides

    bool vertical_is_known = true;  // false: refuses what depends on where world z points

    int num_replicates = 100;
    std::uint64_t seed = 1;
    int num_threads = 0;  // 0: all cores; never changes a result
};

}  // namespace divemesh::reef
