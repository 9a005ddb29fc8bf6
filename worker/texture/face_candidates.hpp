#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace divemesh::texture {

// A keyframe that shows all of a triangle. Eight bytes, because there are many of them.
struct Candidate {
    std::uint16_t view = 0;     // index of the keyframe
    std::uint16_t quality = 0;  // on a logarithmic scale: kQualitySteps for each factor of two
    std::array<std::uint8_t, 3> bgr = {};  // mean colour of the triangle

    static constexpr float kQualitySteps = 1024.0F;

    static std::uint16_t encoded_quality(float quality) {
        return static_cast<std::uint16_t>(
            std::clamp(kQualitySteps * (std::log2(quality) + 32.0F), 0.0F, 65535.0F));
    }
};
static_assert(sizeof(Candidate) == 8);

// The best candidates of each triangle: at most kMaxViews. Threads may write different triangles.
class FaceCandidates {
public:
    static constexpr std::size_t kMaxViews = 8;

    explicit FaceCandidates(std::size_t num_faces)
        : candidates_(num_faces * kMaxViews), num_(num_faces, 0) {}

    std::size_t num_faces() const { return num_.size(); }
    std::span<const Candidate> of(std::size_t face) const {
        return {candidates_.data() + face * kMaxViews, num_[face]};
    }

    // Adds a candidate, in place of the worst one where there is no room. Views must come in
    // ascending order, so that those of a triangle stay in it.
    void add(std::size_t face, const Candidate& candidate) {
        Candidate* first = candidates_.data() + face * kMaxViews;
        if (num_[face] == kMaxViews) {
            Candidate* worst = std::min_element(
                first, first + kMaxViews, [](const Candidate& a, const Candidate& b) {
                    return a.quality < b.quality;
                });
            if (worst->quality >= candidate.quality) return;
            std::copy(worst + 1, first + kMaxViews, worst);
            --num_[face];
        }
        first[num_[face]++] = candidate;
    }

    // Removes the candidates whose bits are set in `dropped`, the lowest bit for the first.
    void drop(std::size_t face, std::uint8_t dropped) {
        Candidate* first = candidates_.data() + face * kMaxViews;
        std::uint8_t num_kept = 0;
        for (std::size_t i = 0; i < num_[face]; ++i)
            if ((dropped >> i & 1U) == 0) first[num_kept++] = first[i];
        num_[face] = num_kept;
    }

private:
    std::vector<Candidate> candidates_;  // kMaxViews places for each triangle
    std::vector<std::uint8_t> num_;
};
static_assert(FaceCandidates::kMaxViews == 8, "drop() has a bit for each");

}  // namespace divemesh::texture
