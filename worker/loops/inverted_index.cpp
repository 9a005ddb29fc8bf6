#include "worker/loops/inverted_index.hpp"

#include <algorithm>
#include <cmath>

#include "worker/features/described_keypoints.hpp"

namespace divemesh::loops {

InvertedIndex::InvertedIndex(const StoredKeypoints& keypoints) {
    const Vocabulary vocabulary = Vocabulary::learn(keypoints);
    keyframes_of_word_.resize(static_cast<std::size_t>(vocabulary.num_words()));
    words_of_keyframe_.resize(keypoints.size());
    for (std::size_t i = 0; i < keypoints.size(); ++i) {
        std::vector<std::int32_t> words;
        for (const features::DescribedKeypoint& point : keypoints[i])
            words.push_back(vocabulary.word_of(point.descriptor));
        std::sort(words.begin(), words.end());
        for (const std::int32_t word : words) {
            auto& entries = words_of_keyframe_[i];
            if (entries.empty() || entries.back().key != word) entries.push_back({word, 0.0F});
            entries.back().weight += 1.0F;
        }
        for (const Entry& entry : words_of_keyframe_[i])
            keyframes_of_word_[static_cast<std::size_t>(entry.key)].push_back(
                {static_cast<std::int32_t>(i), 0.0F});
    }
    const auto num_keyframes = static_cast<float>(keypoints.size());
    for (std::size_t i = 0; i < keypoints.size(); ++i) {
        float sum = 0.0F;
        for (Entry& entry : words_of_keyframe_[i]) {
            const auto& seen_by = keyframes_of_word_[static_cast<std::size_t>(entry.key)];
            entry.weight *= std::log(1.0F + num_keyframes / static_cast<float>(seen_by.size()));
            sum += entry.weight;
        }
        for (Entry& entry : words_of_keyframe_[i]) entry.weight /= sum;
    }
    for (auto& entries : keyframes_of_word_) entries.clear();
    for (std::size_t i = 0; i < keypoints.size(); ++i)
        for (const Entry& entry : words_of_keyframe_[i])
            keyframes_of_word_[static_cast<std::size_t>(entry.key)].push_back(
                {static_cast<std::int32_t>(i), entry.weight});
}

std::vector<float> InvertedIndex::similarity(std::size_t keyframe) const {
    std::vector<float> shared(words_of_keyframe_.size(), 0.0F);
    for (const Entry& word : words_of_keyframe_[keyframe])
        for (const Entry& other : keyframes_of_word_[static_cast<std::size_t>(word.key)])
            shared[static_cast<std::size_t>(other.key)] += std::min(word.weight, other.weight);
    return shared;
}

}  // namespace divemesh::loops
