#include "worker/texture/photo_consistency.hpp"

#include <algorithm>
#include <bit>
#include <cstdint>
#include <vector>

#include "worker/stats/median.hpp"
#include "worker/stats/robust.hpp"
#include "worker/texture/water_light.hpp"

namespace divemesh::texture {
namespace {

constexpr float kMaxSigmas = 4.0F;
// Logarithms of colours differ by this without a fish too: a near image has more contrast than far
// ones.
constexpr float kMinSigma = 0.06F;

// A bit for each candidate of a triangle.
using Marks = std::uint8_t;

// Returns the standard deviation of a channel in a triangle: at an edge of the texture more than
// elsewhere, as no pose is exact.
float sigma_in_face(const ColorResiduals& residuals,
                    std::size_t num,
                    int channel,
                    const WaterLight& light) {
    std::vector<double> sizes;
    for (std::size_t i = 0; i < num; ++i)
        sizes.push_back(static_cast<double>(std::abs(residuals[i][channel])));
    const auto sigma = static_cast<float>(stats::kSigmasPerMad * stats::median(std::move(sizes)));
    return std::max({sigma, light.sigma[channel], kMinSigma});
}

// Channels are compared one by one: they are too correlated to add up their deviations.
Marks outliers(const SeenMesh& seen, const WaterLight& light, std::size_t face) {
    const std::size_t num = seen.candidates.of(face).size();
    if (num < kMinJudgedViews) return 0;
    const ColorResiduals residuals = color_residuals(seen, light, face);
    Marks marks = 0;
    for (int channel = 0; channel < 3; ++channel) {
        const float limit = kMaxSigmas * sigma_in_face(residuals, num, channel, light);
        for (std::size_t i = 0; i < num; ++i)
            if (std::abs(residuals[i][channel]) > limit)
                marks = static_cast<Marks>(marks | 1U << i);
    }
    return marks;
}

// Returns the bits of a triangle's candidates whose keyframes are marked at a neighbour.
Marks marks_of_neighbour(std::span<const Candidate> candidates,
                         std::span<const Candidate> neighbours,
                         Marks marked) {
    Marks marks = 0;
    for (std::size_t i = 0; marked != 0 && i < candidates.size(); ++i)
        for (std::size_t j = 0; j < neighbours.size(); ++j)
            if ((marked >> j & 1U) != 0 && neighbours[j].view == candidates[i].view)
                marks = static_cast<Marks>(marks | 1U << i);
    return marks;
}

// Returns the marks of a triangle with those of its neighbours, as far as a candidate is left.
Marks dilated(const FaceCandidates& candidates,
              const FaceGraph& graph,
              const std::vector<Marks>& marks,
              std::size_t face) {
    const std::span<const Candidate> own = candidates.of(face);
    Marks all = marks[face];
    for (const FaceLink& link : graph.links(face))
        all = static_cast<Marks>(
            all | marks_of_neighbour(own, candidates.of(link.face), marks[link.face]));
    if (std::popcount(all) < static_cast<int>(own.size())) return all;
    return std::popcount(marks[face]) < static_cast<int>(own.size()) ? marks[face] : Marks{0};
}

}  // namespace

void drop_inconsistent_views(const types::Mesh& mesh,
                             const std::vector<types::Keyframe>& keyframes,
                             const FaceGraph& graph,
                             int num_threads,
                             const base::ProgressShare& progress,
                             FaceCandidates& candidates) {
    const SeenMesh seen{mesh, keyframes, candidates};
    const WaterLight light = fit_water_light(seen, num_threads);
    const std::size_t num_faces = candidates.num_faces();
    std::vector<Marks> marks(num_faces);
    base::for_each_index(num_threads, num_faces, progress, [&](std::size_t face) {
        marks[face] = outliers(seen, light, face);
    });
    std::vector<Marks> dropped(num_faces);
    base::for_each_index(num_threads, num_faces, [&](std::size_t face) {
        dropped[face] = dilated(candidates, graph, marks, face);
    });
    for (std::size_t face = 0; face < num_faces; ++face) candidates.drop(face, dropped[face]);
}

}  // namespace divemesh::texture
