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

// A picture, or why there is none.
struct LoadedImage {
    cv::Mat image;
    std::string code;     // "" when there is one, else a finding's code
    std::string problem;  // in words
    bool was_16_bit = false;
};

LoadedImage load_image(const DiveFiles& files,
                       const std::string& path,
                       const types::Camera& camera,
                       const DiveLimits& limits,
                       Channels channels);

// A pair as far as it could be loaded, grey.
struct LoadedPair {
    int index = 0;
    LoadedImage left;
    LoadedImage right;

    bool is_complete() const { return !left.image.empty() && !right.image.empty(); }
};

// Hands out the pairs in order and decodes a few ahead on other threads; memory is bounded by
// those.
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
