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

// The part of a mesh over an outline with all that its figures are taken from.
struct OutlineSurvey {
    AreaPlane plane;
    std::vector<SurfacePatch> patch;  // one
    SamplingResolution sampling_resolution;
    GridShape shape;
    std::vector<std::uint8_t> within;  // of the nodes, those of the outline
    bool has_hidden = false;           // of these, some were not seen

    HeightGrid grid(const std::vector<Eigen::Vector3d>& vertices) const;
    Ground ground(const std::vector<Eigen::Vector3d>& vertices,
                  int num_blurs = 0,
                  HeightGrid bridge(const HeightGrid&) = gaps_filled) const;
};

// Nothing but the patch and its fineness where the outline is too large for samples of 25 cm.
struct CutOutline {
    OutlineSurvey survey;
    bool has_samples = false;
};
CutOutline cut_outline(const types::Mesh& mesh,
                       const AreaPlane& plane,
                       const MeasureOptions& options);

// Brings the vertices' local sigma down to what the surface shows of it, no more than `most` of
// what is stated. Answers the share that was kept.
double limit_to_noise_level(OutlineSurvey& survey, double most);

struct SeenNodes {
    double num_within = 0.0;
    double num_seen = 0.0;
    double num_border = 0.0;  // sides between seen nodes and what was not seen
};
SeenNodes count_seen(const OutlineSurvey& survey);

}  // namespace divemesh::reef
