#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "worker/evaluation/known_distances.hpp"
#include "worker/evaluation/scale_check.hpp"
#include "worker/types/loop_statistics.hpp"
#include "worker/types/path_uncertainty.hpp"
#include "worker/types/recording.hpp"

namespace divemesh::evaluation {

// A metric that cannot be given, and the reason.
struct LeftOut {
    std::string metric;
    std::string reason;
};

// A sensor that measures lengths, and its scale against the cameras.
struct ScaleSource {
    std::string name;  // in metrics.json
    ScaleCheck check;
};

// The data that measure lengths besides the cameras; empty where there are none or they must not be
// used.
struct LengthData {
    std::vector<types::ImuSample> imu;  // on the cameras' clock
    std::vector<types::PressureSample> pressure;
    std::optional<ScaleCheck> markers;    // known distances between them
    std::optional<ScaleCheck> positions;  // by instruments outside of the rig
    // Lengths of measurements.json between places that are marked in the images; their sigmas leave
    // out the error of the path's scale.
    KnownDistanceErrors marked_distances;
    const KnownDistanceErrors* known_distances = nullptr;  // all of measurements.json
    std::size_t num_segments = 1;                          // of the dive
};

// The scale by all sources, without the error of the cameras' own scale.
struct ScaleSources {
    std::vector<ScaleSource> usable;  // to 10 % or better
    std::vector<LeftOut> left_out;    // the others
};

// Returns the factor on the standard deviations of a path, by how far it misses its closed loops; 1
// without loops, as there are no residuals then.
double covariance_scale(const types::LoopStatistics& loops);

// Returns the sources with the sigma of the path's own scale added: 1 should lie within theirs.
std::vector<ScaleSource> against_path(std::vector<ScaleSource> sources,
                                      const types::PathUncertainty& path);

// Returns the largest difference from 1 among the sources that contradict the path; 0: none does.
double scale_contradiction(const std::vector<ScaleSource>& sources,
                           const types::PathUncertainty& path);

// Returns the scale of a path by each source. The correction of the scale and the report of it both
// read this.
ScaleSources scale_sources(const LengthData& lengths,
                           const types::Trajectory& trajectory,
                           const types::PathUncertainty& path,
                           const types::LoopStatistics& loops);

}  // namespace divemesh::evaluation
