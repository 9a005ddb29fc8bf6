#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "worker/texture/seam_colors.hpp"

namespace divemesh::texture {

// The corners of a mesh's triangles, numbered so that triangles of the same keyframe share those of
// the same vertex.
class ColoredVertices {
public:
    ColoredVertices(const types::Mesh& mesh, const FaceViews& views);

    std::size_t size() const { return keyframes_.size(); }
    // Returns the number of a vertex in the colours of a keyframe that colours a triangle there.
    std::size_t number(std::uint32_t vertex, std::int32_t keyframe) const;

private:
    std::vector<std::uint32_t> begin_;     // of each vertex, in keyframes_
    std::vector<std::int32_t> keyframes_;  // ascending within a vertex
};

// How the colours of the images (b g r, 0 to 255) change in the texture.
struct Levelling {
    std::vector<Eigen::Vector3f> gains;  // of each keyframe
    ColoredVertices vertices;
    std::vector<Eigen::Vector3f> added;  // after the gain, to each of `vertices`; linear between

    Eigen::Vector3f added_at(std::uint32_t vertex, std::int32_t keyframe) const {
        return added[vertices.number(vertex, keyframe)];
    }
    // Returns the colour of a sample after levelling.
    Eigen::Vector3f color(const SeamColors& colors,
                          const Seam& seam,
                          std::size_t side,
                          std::uint32_t sample) const;
};

// Levels the seams over the whole mesh (Lempitsky and Ivanov, "Seamless mosaicing of image-based
// texture maps", 2007): by a gain per keyframe, for exposure, and then by what is added at each
// vertex in each keyframe, for backscatter and range. Both sides of a seam agree, and what is added
// changes slowly in between. Its mean is 0.
Levelling level_seams(const types::Mesh& mesh,
                      const FaceViews& views,
                      const SeamColors& colors,
                      std::size_t num_keyframes,
                      const base::ProgressShare& progress);

}  // namespace divemesh::texture
