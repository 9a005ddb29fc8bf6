#pragma once

#include <functional>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "worker/reef/height_grid.hpp"
#include "worker/reef/measure_options.hpp"
#include "worker/reef/sampling_resolution.hpp"
#include "worker/reef/surface_patch.hpp"

namespace divemesh::reef {

// What a figure is taken from.
struct Ground {
    const SurfacePatch& patch;
    const std::vector<Eigen::Vector3d>& vertices;  // of the patch, noise added or not
    HeightGrid grid;                               // the finest; what was seen
    HeightGrid gaps_filled;                        // with what was not seen in between bridged
    double lost_to_blur_m2 = 0.0;                  // of the area of `grid`
    Eigen::Matrix3d R_world_plane = Eigen::Matrix3d::Identity();

    HeightGrid at(double spacing_m) const;              // a multiple of the grid's
    HeightGrid gaps_filled_at(double spacing_m) const;  // likewise
    HeightGrid near(double spacing_m) const;            // no coarser, if the grid lets
};

struct MetricKind {
    std::string metric;
    std::string unit;
    std::optional<double> resolution_m;
    std::string method;
    double lowest = -std::numeric_limits<double>::infinity();  // that the figure can be
    double highest = std::numeric_limits<double>::infinity();
    bool is_extreme = false;           // unseen ground would change it
    bool loses_detail = false;         // blurring takes from it
    bool is_direction = false;         // deg, 360 is 0
    int length_power = 0;              // by which the figure goes with the scale of all lengths
    bool is_from_plane = false;        // what moves all of the surface along the normal changes it
    bool needs_height_spread = false;  // beyond what the surface errs by
    std::function<std::optional<double>(const Ground&)> measure;
};

// Of an area with an outline, in the order in which they are reported. `finest_m`: the shortest of
// the options' spacings that can be said something at; nothing when there is none.
std::vector<MetricKind> area_metrics(const MeasureOptions& options,
                                     const SamplingResolution& sampling_resolution,
                                     std::optional<double> finest_m);

}  // namespace divemesh::reef
