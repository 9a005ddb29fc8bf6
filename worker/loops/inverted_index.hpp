#pragma once

#include <cstdint>
#include <vector>

#include "worker/loops/vocabulary.hpp"

namespace divemesh::loops {

// An index of similar keyframes: an inverted file from visual words to the keyframes that show them
// (Sivic and Zisserman 2003), with words weighted by their rarity.
class InvertedIndex {
public:
    explicit InvertedIndex(const StoredKeypoints& keypoints);

    // Returns the similarity of `keyframe` with every keyframe, 0 to 1: the shared part of
    // their word histograms.
    std::vector<float> similarity(std::size_t keyframe) const;

private:
    struct Entry {
        std::int32_t key = 0;  // a keyframe in a word's list, a word in a keyframe's list
        float weight = 0.0F;
    };
    std::vector<std::vector<Entry>> words_of_keyframe_;
    std::vector<std::vector<Entry>> keyframes_of_word_;
};

}  // namespace divemesh::loops
