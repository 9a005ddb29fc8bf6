#pragma once

#include <optional>
#include <string>

#include "worker/reef/measure_options.hpp"
#include "worker/reef/surface_patch.hpp"

namespace divemesh::reef {

// The resolution at which the ground was measured.
struct SamplingResolution {
    std::optional<double> sigma_m;        // that most of the ground does not exceed
    std::optional<double> sigma_local_m;  // the same of the noise only
    std::optional<double> detail_m;       // size of the smallest detail that the surface holds
    double correlation_length_m = 0.0;
    double min_sample_m = 0.0;  // of a grid whose samples fit the memory limit
};

// Returns the resolution of a patch. The cameras are in the patch's frame.
SamplingResolution sampling_resolution_of(const SurfacePatch& patch,
                                          const std::vector<Eigen::Vector3d>& cameras_plane,
                                          const MeasureOptions& options);

std::string length_text(double length_m);  // mm

// Returns why a spacing is refused: below three sigma, finer than the detail, or finer than the
// samples. Returns nullopt if it is not refused.
std::optional<std::string> refused_at(double spacing_m,
                                      const SamplingResolution& sampling_resolution);

// Returns the first spacing that is not refused; nullopt if there is none.
std::optional<double> finest_spacing_m(const MeasureOptions& options,
                                       const SamplingResolution& sampling_resolution);

// Fills in missing sigmas: with the option's sigma, otherwise with the typical one of the other
// vertices.
void fill_in_sigma(SurfacePatch& patch, const MeasureOptions& options);

}  // namespace divemesh::reef
