#include "worker/reef/sampling_resolution.hpp"

#include <algorithm>
#include <cmath>

#include "worker/base/text.hpp"

namespace divemesh::reef {

std::string length_text(double length_m) { return base::fixed(1000.0 * length_m, 1) + " mm"; }

SamplingResolution sampling_resolution_of(const SurfacePatch& patch,
                                          const std::vector<Eigen::Vector3d>& cameras_plane,
                                          const MeasureOptions& options) {
    SamplingResolution sampling_resolution;
    sampling_resolution.sigma_m = sigma_of_most_m(patch, patch.sigma_m);
    sampling_resolution.sigma_local_m = sigma_of_most_m(patch, patch.sigma_local_m);
    const double two_sides_m = 2.0 * median_edge_m(patch);
    double detail =
        options.is_simplified ? std::max(options.min_detail_m, two_sides_m) : options.min_detail_m;
    double window = two_sides_m;
    const auto range = median_range_m(patch, cameras_plane);
    if (range && options.focal_px > 0.0) {
        detail = std::max(detail, options.support_px * *range / options.focal_px);
        window = options.window_px * *range / options.focal_px;
    }
    if (detail > 0.0) sampling_resolution.detail_m = detail;
    sampling_resolution.correlation_length_m =
        options.correlation_length_m > 0.0 ? options.correlation_length_m : window;
    return sampling_resolution;
}

std::optional<std::string> refused_at(double spacing_m,
                                      const SamplingResolution& sampling_resolution) {
    constexpr double kSlack_m = 1e-9;
    if (sampling_resolution.sigma_m && spacing_m + kSlack_m < 3.0 * *sampling_resolution.sigma_m)
        return "below 3 sigma of the surface, " + length_text(3.0 * *sampling_resolution.sigma_m);
    if (sampling_resolution.detail_m && spacing_m + kSlack_m < *sampling_resolution.detail_m)
        return "finer than the detail of the surface, " +
               length_text(*sampling_resolution.detail_m);
    if (spacing_m + kSlack_m < sampling_resolution.min_sample_m)
        return "the area is too large for samples closer than " +
               length_text(sampling_resolution.min_sample_m);
    return std::nullopt;
}

std::optional<double> finest_spacing_m(const MeasureOptions& options,
                                       const SamplingResolution& sampling_resolution) {
    for (const double spacing_m : options.spacings_m)
        if (!refused_at(spacing_m, sampling_resolution)) return spacing_m;
    return std::nullopt;
}

void fill_in_sigma(SurfacePatch& patch, const MeasureOptions& options) {
    for (std::vector<double>* sigmas : {&patch.sigma_m, &patch.sigma_local_m}) {
        const double typical =
            options.sigma_m > 0.0 ? options.sigma_m : typical_sigma_m(*sigmas).value_or(0.0);
        for (double& sigma : *sigmas)
            if (sigma <= 0.0) sigma = typical;
    }
    patch.sigma_bend_m.clear();
    for (std::size_t i = 0; i < patch.sigma_m.size(); ++i)
        patch.sigma_bend_m.push_back(
            std::sqrt(std::max(0.0,
                               patch.sigma_m[i] * patch.sigma_m[i] -
                                   patch.sigma_local_m[i] * patch.sigma_local_m[i])));
}

}  // namespace divemesh::reef
