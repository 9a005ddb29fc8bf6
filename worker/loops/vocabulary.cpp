#include "worker/loops/vocabulary.hpp"

#include <algorithm>

namespace divemesh::loops {
namespace {

constexpr std::size_t kBranches = 10;
constexpr int kSweeps = 5;
constexpr std::size_t kMaxSamples = 25'000;  // about 20 for a word of the third level
// From this many descriptors a fourth level keeps the lists of the words short.
constexpr std::size_t kManyDescriptors = 500'000;

features::Descriptor majority(const std::vector<features::Descriptor>& members) {
    std::array<std::size_t, 256> votes{};
    for (const features::Descriptor& member : members)
        for (std::size_t bit = 0; bit < votes.size(); ++bit)
            votes[bit] += (member[bit / 64] >> (bit % 64)) & 1U;
    features::Descriptor centre{};
    for (std::size_t bit = 0; bit < votes.size(); ++bit)
        if (2 * votes[bit] > members.size()) centre[bit / 64] |= std::uint64_t{1} << (bit % 64);
    return centre;
}

std::size_t nearest(const std::vector<features::Descriptor>& centres,
                    const features::Descriptor& descriptor) {
    std::size_t best = 0;
    int min_distance = 257;
    for (std::size_t i = 0; i < centres.size(); ++i) {
        const int distance = features::hamming_distance(centres[i], descriptor);
        if (distance >= min_distance) continue;
        min_distance = distance;
        best = i;
    }
    return best;
}

using Clusters = std::vector<std::vector<features::Descriptor>>;

// Clusters descriptors by k-majority: k-means in Hamming space. `centres` become those of the
// clusters.
Clusters cluster(const std::vector<features::Descriptor>& descriptors,
                 std::vector<features::Descriptor>& centres) {
    Clusters clusters;
    for (int sweep = 0; sweep < kSweeps; ++sweep) {
        clusters.assign(centres.size(), {});
        for (const features::Descriptor& descriptor : descriptors)
            clusters[nearest(centres, descriptor)].push_back(descriptor);
        for (std::size_t i = 0; i < centres.size(); ++i)
            if (!clusters[i].empty()) centres[i] = majority(clusters[i]);
    }
    return clusters;
}

}  // namespace

Vocabulary Vocabulary::learn(const StoredKeypoints& keypoints) {
    std::size_t num_descriptors = 0;
    for (std::size_t k = 0; k < keypoints.size(); ++k) num_descriptors += keypoints[k].size();
    const std::size_t stride = 1 + num_descriptors / kMaxSamples;
    std::vector<features::Descriptor> samples;
    std::size_t i = 0;
    for (std::size_t k = 0; k < keypoints.size(); ++k)
        for (const features::DescribedKeypoint& point : keypoints[k])
            if (i++ % stride == 0) samples.push_back(point.descriptor);
    Vocabulary vocabulary;
    vocabulary.nodes_.emplace_back();
    vocabulary.grow(0, samples, num_descriptors < kManyDescriptors ? 3 : 4);
    return vocabulary;
}

void Vocabulary::grow(std::int32_t node,
                      std::vector<features::Descriptor>& descriptors,
                      int depth) {
    if (depth == 0 || descriptors.size() <= kBranches) {
        nodes_[static_cast<std::size_t>(node)].word = num_words_++;
        return;
    }
    std::vector<features::Descriptor> centres;
    for (std::size_t i = 0; i < kBranches; ++i)
        centres.push_back(descriptors[i * descriptors.size() / kBranches]);
    Clusters clusters = cluster(descriptors, centres);
    descriptors.clear();
    for (std::size_t i = 0; i < kBranches; ++i) {
        if (clusters[i].empty()) continue;
        const auto child = static_cast<std::int32_t>(nodes_.size());
        nodes_.push_back({centres[i], {}, -1});
        nodes_[static_cast<std::size_t>(node)].children.push_back(child);
        grow(child, clusters[i], depth - 1);
    }
}

std::int32_t Vocabulary::nearest_child(const Node& node,
                                       const features::Descriptor& descriptor) const {
    std::int32_t best = node.children.front();
    int min_distance = 257;
    for (const std::int32_t child : node.children) {
        const int distance =
            features::hamming_distance(nodes_[static_cast<std::size_t>(child)].centre, descriptor);
        if (distance >= min_distance) continue;
        min_distance = distance;
        best = child;
    }
    return best;
}

std::int32_t Vocabulary::word_of(const features::Descriptor& descriptor) const {
    const Node* node = &nodes_.front();
    while (!node->children.empty())
        node = &nodes_[static_cast<std::size_t>(nearest_child(*node, descriptor))];
    return node->word;
}

}  // namespace divemesh::loops
