#pragma once

#include <cstdint>
#include <vector>

#include "worker/features/described_keypoints.hpp"
#include "worker/loops/stored_keypoints.hpp"

namespace divemesh::loops {

// Visual words: a tree of cluster centres of descriptors, learnt from the dive itself (Nister and
// Stewenius 2006; binary centres by majority vote as in Galvez-Lopez and Tardos 2012). The same
// descriptors give the same tree.
class Vocabulary {
public:
    static Vocabulary learn(const StoredKeypoints& keypoints);

    std::int32_t word_of(const features::Descriptor& descriptor) const;
    std::int32_t num_words() const { return num_words_; }

private:
    struct Node {
        features::Descriptor centre{};
        std::vector<std::int32_t> children;  // indices into nodes_; empty: a word
        std::int32_t word = -1;
    };
    void grow(std::int32_t node, std::vector<features::Descriptor>& descriptors, int depth);
    std::int32_t nearest_child(const Node& node, const features::Descriptor& descriptor) const;

    std::vector<Node> nodes_;  // index 0: the root
    std::int32_t num_words_ = 0;
};

}  // namespace divemesh::loops
