#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "schemas/finding.hpp"
#include "schemas/reconstruction_options.hpp"
#include "worker/evaluation/expected_accuracy.hpp"
#include "worker/mesh/image_coverage.hpp"
#include "worker/pipeline/map_metrics.hpp"
#include "worker/pipeline/texture_metrics.hpp"
#include "worker/types/refined_calibration.hpp"
#include "worker/types/tracking_segment.hpp"

// Findings about the result as a whole: what is not known about it.
namespace divemesh::pipeline {

// Returns a warning if the dive fell into segments.
std::optional<Finding> segments_finding(const std::vector<types::TrackingSegment>& segments);

// Returns a warning if no sensor and no known distance tested the scale.
std::optional<Finding> scale_finding(const evaluation::ExpectedAccuracy& expected);

// Returns a warning if the stated error of all lengths is larger than a calibration's can be.
std::optional<Finding> scale_uncertainty_finding(const evaluation::ExpectedAccuracy& expected);

// Returns a warning if the error of a connected path has no bound.
std::optional<Finding> bounds_finding(const evaluation::ExpectedAccuracy& expected,
                                      std::size_t num_segments);

// Returns a warning if no sensor measured which way is up.
std::optional<Finding> vertical_finding(bool vertical_known);

// Returns a warning if a rolling shutter bends the images.
std::optional<Finding> shutter_finding(const types::RefinedCalibration& calibration);

// Returns a warning if much of the fused depth makes no surface: more than a quarter lies beyond
// `max_depth_m` (unless that was limited on purpose), or more than half is too far or too
// uncertain.
std::optional<Finding> left_out_finding(const fusion::FusedPixels& pixels,
                                        double max_depth_m,
                                        const VoxelSizes& voxels,
                                        const ReconstructionOptions& options);

// Returns an error if a surface without triangles was made.
std::optional<Finding> surface_finding(std::int64_t num_triangles);

// Returns a warning if the surface lacks much of what the cameras matched. `cut_by_sigma_m2` is
// what the option max_sigma_m removed.
std::optional<Finding> incomplete_finding(const std::vector<mesh::ImageCoverage>& images,
                                          double cut_by_sigma_m2);

// Returns a warning if photographs are missing: images of keyframes could not be read for the
// texture, or more than 15 % of the area of the surface has none.
std::optional<Finding> texture_finding(const TextureMetrics& texture, std::int64_t num_keyframes);

}  // namespace divemesh::pipeline
