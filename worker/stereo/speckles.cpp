#include "worker/stereo/speckles.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include "worker/disjoint_sets.hpp"

namespace divemesh::worker {
namespace {

// Pixels of one row that hang together.
struct Run {
    std::int32_t begin;
    std::int32_t end;
};

}  // namespace

void remove_speckles(cv::Mat& disparity_px, int min_pixels, float max_step_px) {
    const auto together = [&](float a, float b) {
        return a > 0.0F && b > 0.0F && std::abs(a - b) <= max_step_px;
    };
    std::vector<Run> runs;
    std::vector<std::size_t> first_of_row{0};
    for (int y = 0; y < disparity_px.rows; ++y) {
        const float* row = disparity_px.ptr<float>(y);
        for (std::int32_t x = 0; x < disparity_px.cols; ++x) {
            if (row[x] <= 0.0F) continue;
            const std::int32_t begin = x;
            while (x + 1 < disparity_px.cols && together(row[x], row[x + 1])) ++x;
            runs.push_back({begin, x + 1});
        }
        first_of_row.push_back(runs.size());
    }
    DisjointSets sets(runs.size());
    for (int y = 1; y < disparity_px.rows; ++y) {
        const float* row = disparity_px.ptr<float>(y);
        const float* above = disparity_px.ptr<float>(y - 1);
        std::size_t a = first_of_row[y - 1];
        std::size_t b = first_of_row[y];
        while (a < first_of_row[y] && b < first_of_row[y + 1]) {
            const std::int32_t end = std::min(runs[a].end, runs[b].end);
            for (std::int32_t x = std::max(runs[a].begin, runs[b].begin); x < end; ++x)
                if (together(row[x], above[x])) {
                    sets.join(a, b);
                    break;
                }
            if (runs[a].end == end)
                ++a;
            else
                ++b;
        }
    }
    std::vector<std::int32_t> size(runs.size(), 0);
    for (std::size_t i = 0; i < runs.size(); ++i) size[sets.find(i)] += runs[i].end - runs[i].begin;
    for (int y = 0; y < disparity_px.rows; ++y)
        for (std::size_t i = first_of_row[y]; i < first_of_row[y + 1]; ++i)
            if (size[sets.find(i)] < min_pixels)
                std::fill(disparity_px.ptr<float>(y) + runs[i].begin,
                          disparity_px.ptr<float>(y) + runs[i].end,
                          0.0F);
}

}  // namespace divemesh::worker
