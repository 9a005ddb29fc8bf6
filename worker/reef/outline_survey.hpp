#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "worker/reef/area_metrics.hpp"
#include "worker/reef/area_plane.hpp"
#include "worker/reef/fill_gaps.hpp"
#include "worker/reef/measure_options.hpp"
#include "worker/reef/sampling_resolution.hpp"
#include "worker/reef/surface_patch.hpp"

namespace divemesh::reef {

// The part of a mesh over an outline, with all that its metrics are computed from.
struct OutlineSurvey {
    AreaPlane plane;
    std::vector<SurfacePatch> patch;  // exactly one
    SamplingResolution sampling_resolution;
    GridShape shape;
    std::vector<std::uint8_t> within;  // per node: 1 within the outline
    bool has_hidden = false;           // some nodes within the outline are unseen

    HeightGrid grid(const std::vector<Eigen::Vector3d>& vertices) const;
    Ground ground(const std::vector<Eigen::Vector3d>& vertices,
                  int num_blurs = 0,
                  HeightGrid bridge(const HeightGrid&) = gaps_filled) const;
};

// An outline's survey. Without samples (the outline is too large even for 25 cm) it has only the
// patch and its resolution.
struct CutOutline {
    OutlineSurvey survey;
    bool has_samples = false;
};
CutOutline cut_outline(const types::Mesh& mesh,
                       const AreaPlane& plane,
                       const MeasureOptions& options);

// Lowers the vertices' local sigma to what the surface shows of it, at most `max_share` of the
// stated one. Returns the share that was kept.
double limit_to_noise_level(OutlineSurvey& survey, double max_share);

// Numbers of nodes of an outline's grid.
struct SeenNodes {
    double num_within = 0.0;
    double num_seen = 0.0;
    double num_border = 0.0;  // sides between seen and unseen nodes
};
SeenNodes count_seen(const OutlineSurvey& survey);

}  // namespace divemesh::reef
