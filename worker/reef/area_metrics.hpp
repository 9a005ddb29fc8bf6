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

// The surface that a metric is computed from.
struct Ground {
    const SurfacePatch& patch;
    const std::vector<Eigen::Vector3d>& vertices;  // of the patch, with or without added noise
    HeightGrid grid;                               // the finest, seen ground only
    HeightGrid gaps_filled;                        // with unseen ground in between filled in
    double lost_to_blur_m2 = 0.0;                  // of the area of `grid`
    bool has_hidden = false;                       // some of the area is unseen
    Eigen::Matrix3d R_world_plane = Eigen::Matrix3d::Identity();

    HeightGrid at(double spacing_m) const;              // `spacing_m`: a multiple of the grid's
    HeightGrid gaps_filled_at(double spacing_m) const;  // the same
    HeightGrid near(double spacing_m) const;            // not coarser, if the grid allows
};

// One kind of metric: its name, unit, method and how it is computed.
struct MetricKind {
    std::string metric;
    std::string unit;
    std::optional<double> resolution_m;
    std::string method;
    double lowest = -std::numeric_limits<double>::infinity();  // range of possible values
    double highest = std::numeric_limits<double>::infinity();
    bool is_extreme = false;           // unseen ground would change it
    bool loses_detail = false;         // blurring reduces it
    bool is_direction = false;         // deg, 360 is 0
    int length_power = 0;              // the power of length with which it scales
    bool is_from_plane = false;        // a shift of the whole surface along the normal changes it
    bool needs_height_spread = false;  // of more than the error of the surface
    std::function<std::optional<double>(const Ground&)> measure;
    // One standard deviation by how rough unseen ground is, beyond that by how its gaps are filled;
    // empty: none.
    std::function<double(const Ground&)> hidden_deviation;
};

// Returns the metrics of an area with an outline, in the order in which they are reported.
// `finest_m`: the smallest of the options' spacings that is not refused; nullopt if there is none.
std::vector<MetricKind> area_metrics(const MeasureOptions& options,
                                     const SamplingResolution& sampling_resolution,
                                     std::optional<double> finest_m);

}  // namespace divemesh::reef
