#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <span>
#include <vector>

#include "worker/texture/face_candidates.hpp"
#include "worker/texture/face_graph.hpp"
#include "worker/texture/face_views.hpp"

namespace divemesh::texture {

// The energy that the choice of views minimises, a Markov random field (Lempitsky and Ivanov 2007):
// over the triangles, the area times the share of resolution lost against the best candidate; over
// the edges between two views, the length times the width of a seam. Neither depends on how finely
// the mesh is triangulated.
struct ViewField {
    const FaceCandidates& candidates;
    const FaceGraph& graph;
    std::vector<float> area_m2;  // of each triangle
    // A seam costs as much as a band of this width without any resolution.
    float seam_width_m = 0.0F;

    // Calls visit(view, cost) for each candidate of a triangle.
    template <typename Visit>
    void for_each_view(std::size_t face, const Visit& visit) const {
        const std::span<const Candidate> views = candidates.of(face);
        std::uint16_t best = 0;
        for (const Candidate& view : views) best = std::max(best, view.quality);
        for (const Candidate& view : views) {
            // Quality goes with the area in the image: its root with resolution.
            const float halvings =
                static_cast<float>(best - view.quality) / (2.0F * Candidate::kQualitySteps);
            visit(view.view, area_m2[face] * (1.0F - std::exp2(-halvings)));
        }
    }
    float seam_cost(const FaceLink& link) const { return seam_width_m * link.edge_m; }

    // Returns true if a seam runs along the edge of a link of the triangle. Triangles without a
    // view are outside the texture.
    static bool is_seam(const FaceViews& views, std::size_t face, const FaceLink& link) {
        return views[face] != views[link.face] && views[face] != kNoView &&
               views[link.face] != kNoView;
    }
};

}  // namespace divemesh::texture
