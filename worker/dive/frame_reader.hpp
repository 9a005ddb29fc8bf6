#pragma once

#include <cstdint>
#include <deque>
#include <functional>
#include <future>
#include <optional>
#include <vector>

#include "worker/dive/dive_files.hpp"
#include "worker/dive/frame_list.hpp"
#include "worker/dive/image.hpp"
#include "worker/types/recording.hpp"

namespace divemesh::dive {

// An image, or the reason why it could not be loaded.
struct LoadedImage {
    cv::Mat image;
    std::string code;     // "" if loaded, else a finding's code
    std::string problem;  // as text
    bool was_16_bit = false;
};

// Loads an image of the camera's size, at 1 / `reduction` of it; a failure is returned, not thrown.
LoadedImage load_image(const DiveFiles& files,
                       const std::string& path,
                       const types::Camera& camera,
                       const DiveLimits& limits,
                       Channels channels,
                       int reduction = 1);

// The images of a pair that are loaded: some checks need the left one alone.
enum class Eyes { Left, Both };

// A stereo pair in grey, as far as it could be loaded.
struct LoadedPair {
    int index = 0;
    LoadedImage left;
    LoadedImage right;

    bool is_complete() const { return !left.image.empty() && !right.image.empty(); }
};

// Returns the pairs in order and decodes a few in advance on other threads, which bounds its
// memory.
class FrameReader {
public:
    using Load = std::function<LoadedPair(int index)>;  // any thread

    FrameReader(int num_pairs, int num_prefetched, Load load)
        : num_pairs_(num_pairs), num_prefetched_(num_prefetched), load_(std::move(load)) {}

    std::optional<LoadedPair> next();
    void rewind();

private:
    int num_pairs_;
    int num_prefetched_;
    Load load_;
    int next_to_load_ = 0;
    std::deque<std::future<LoadedPair>> prefetched_;
};

}  // namespace divemesh::dive
