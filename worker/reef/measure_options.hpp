#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

namespace divemesh::reef {

struct MeasureOptions {
    std::vector<double> spacings_m = {0.01, 0.02, 0.05, 0.10, 0.25, 0.50};  // multiples of 1 cm
    // Share of an area that must have been seen; for heights and volumes, which one more stone in
    // what was not seen would change, the second.
    double min_coverage = 0.5;
    double min_coverage_of_extremes = 0.9;

    // What says how fine the surface is. A disparity is made from a support of pixels: detail
    // shorter than that at the range of the ground is not in the mesh, and what one window measured
    // errs together. Without cameras the mesh is taken for as fine as its triangles.
    std::vector<Eigen::Vector3d> camera_positions_world;
    double focal_px = 0.0;
    double support_px = 15.0;   // census signature of 9 px, refined over windows of 7 px
    double window_px = 7.0;     // over which noise is shared
    double min_detail_m = 0.0;  // two voxels

    double sigma_m = 0.0;                // of the vertices where the mesh does not say
    double sigma_shared_m = 0.0;         // by which poses move all of an area along its normal
    double scale_sigma = 0.001;          // of all lengths: a careful calibration's
    double noise_share = 1.0;            // of the stated local sigma, the most that is there
    double sigma_relative_error = 0.25;  // how far sigma itself may be off: relative, one deviation
    double correlation_length_m = 0.0;   // of the noise; 0: window_px, else two triangle sides

    int num_replicates = 100;
    std::uint64_t seed = 1;
    int num_threads = 0;  // 0: all cores; never changes a figure
};

}  // namespace divemesh::reef
