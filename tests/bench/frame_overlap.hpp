#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <vector>

namespace divemesh::bench {

// The frames of a dive that `divemesh simulate --truth` rendered, with what each saw.
class FrameOverlap {
public:
    explicit FrameOverlap(const std::filesystem::path& dive);
    ~FrameOverlap();

    int num_frames() const;
    // Returns the share of the left image of `a` whose surface is inside the left image of `b`, by
    // exact depth and motion. What is hidden counts as seen.
    double between(int a, int b) const;
    // Returns frames, the first among them, each the last one that overlaps with the one before by
    // at least `overlap`.
    std::vector<int> spaced_by(double overlap) const;

private:
    struct Frames;
    std::unique_ptr<Frames> frames_;
};

}  // namespace divemesh::bench
