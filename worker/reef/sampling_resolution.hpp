#pragma once

#include <optional>
#include <string>

#include "worker/reef/measure_options.hpp"
#include "worker/reef/surface_patch.hpp"

namespace divemesh::reef {

// How fine the ground was measured.
struct SamplingResolution {
    std::optional<double> sigma_m;        // of the vertices, root of the mean square
    std::optional<double> sigma_local_m;  // likewise, of their noise alone
    std::optional<double> detail_m;       // shortest that the surface holds
    double correlation_length_m = 0.0;
    double min_sample_m = 0.0;  // of a grid with no more samples than memory is for
};

// Cameras in the patch's frame.
SamplingResolution sampling_resolution_of(const SurfacePatch& patch,
                                          const std::vector<Eigen::Vector3d>& cameras_plane,
                                          const MeasureOptions& options);

std::string length_text(double length_m);  // mm

// Why nothing can be said at this spacing, below three sigma, finer than the detail or than the
// samples; nothing when it can.
std::optional<std::string> refused_at(double spacing_m,
                                      const SamplingResolution& sampling_resolution);

// The first of the spacings at which something can be said.
std::optional<double> finest_spacing_m(const MeasureOptions& options,
                                       const SamplingResolution& sampling_resolution);

// Vertices of which nothing is known get the option's sigma, else what is typical of the others.
void fill_in_sigma(SurfacePatch& patch, const MeasureOptions& options);

}  // namespace divemesh::reef
