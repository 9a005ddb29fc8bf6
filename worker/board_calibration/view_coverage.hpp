#pragma once

#include <Eigen/Core>
#include <array>
#include <opencv2/core/types.hpp>
#include <string>
#include <vector>

#include "worker/board_calibration/rig_problem.hpp"

namespace divemesh::board_calibration {

inline constexpr int kCoverageColumns = 12;
inline constexpr int kCoverageRows = 8;

// A cell of the grid over an image in which corners are counted.
struct CoverageCell {
    int column = 0;
    int row = 0;
};
CoverageCell coverage_cell(const Eigen::Vector2d& pixel, cv::Size size);

// Where in its images a camera saw corners.
struct ImageCoverage {
    std::array<std::array<int, kCoverageColumns>, kCoverageRows> num_corners = {};

    double share() const;  // of cells with a corner
    // Returns the sixths of the image without a corner: "upper left", "upper middle", ...
    std::vector<std::string> empty_sixths() const;
};

// Smallest and largest of a value over the views.
struct Spread {
    double min = 0.0;
    double max = 0.0;
};

// Where the board was held.
struct ViewCoverage {
    ImageCoverage left;
    ImageCoverage right;
    Spread distance_m;  // of the board's centre from cam0
    Spread tilt_deg;    // of its normal to the axis of cam0
};

ViewCoverage coverage_of(const boards::Board& board,
                         const RigParameters& rig,
                         const std::vector<PosedView>& views);

}  // namespace divemesh::board_calibration
