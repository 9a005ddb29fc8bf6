#pragma once

#include <vector>

#include "worker/features/described_keypoints.hpp"
#include "worker/keyframes/keyframe_store.hpp"

namespace divemesh::loops {

// What the keyframes of a dive are recognised by, in order, from where it is kept: of an hour it
// would take a third of a gigabyte. Refers to both.
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
