#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <vector>

namespace divemesh::bench {

// Measures how far images of a dive that `divemesh simulate --truth` rendered show the same
// surface.
class FrameOverlap {
public:
    explicit FrameOverlap(const std::filesystem::path& dive);
    ~FrameOverlap();

    int num_frames() const;
    // Returns the share of the left image of frame `a` whose surface projects into the left image
    // of frame `b`, by true depth and pose. Occlusion is ignored.
    double between(int a, int b) const;
    // Returns frame indices that begin with the first frame. Each is the last frame that overlaps
    // with the index before by at least `overlap`.
    std::vector<int> spaced_by(double overlap) const;

private:
    struct Frames;
    std::unique_ptr<Frames> frames_;
};

}  // namespace divemesh::bench
