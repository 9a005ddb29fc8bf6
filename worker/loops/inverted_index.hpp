#pragma once

#include <cstdint>
#include <vector>

#include "worker/features/described_keypoints.hpp"
#include "worker/loops/vocabulary.hpp"

namespace divemesh::loops {

// Which views look alike: an inverted file from visual words to the views that show them (Sivic
// and Zisserman 2003), words weighted by how rare they are.
class InvertedIndex {
public:
    explicit InvertedIndex(const StoredKeypoints& views);

    // Likeness of view `view` with every view, 0 to 1: the shared part of their histograms of
    // words.
    std::vector<float> similarity(std::size_t view) const;

private:
    struct Entry {
        std::int32_t key = 0;  // view in a word's list, word in a view's
        float weight = 0.0F;
    };
    std::vector<std::vector<Entry>> words_of_view_;
    std::vector<std::vector<Entry>> views_of_word_;
};

}  // namespace divemesh::loops
