#pragma once

#include <vector>

#include "worker/features/described_keypoints.hpp"
#include "worker/keyframes/keyframe_store.hpp"

namespace divemesh::loops {

// The keypoints of a dive's keyframes, in order, read from the store on access: for an hour-long
// dive they would take a third of a gigabyte of memory. Keeps references to both arguments.
class StoredKeypoints {
public:
    StoredKeypoints(const keyframes::KeyframeStore& store,
                    const std::vector<types::Keyframe>& keyframes)
        : store_(store), keyframes_(keyframes) {}

    std::size_t size() const { return keyframes_.size(); }
    // Throws Error{BadData} when the file is missing or damaged.
    features::DescribedKeypoints operator[](std::size_t keyframe) const {
        return store_.read_keypoints(keyframes_[keyframe].frame_index);
    }

private:
    const keyframes::KeyframeStore& store_;
    const std::vector<types::Keyframe>& keyframes_;
};

}  // namespace divemesh::loops
