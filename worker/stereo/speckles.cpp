#include "worker/stereo/speckles.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include "worker/base/disjoint_sets.hpp"

namespace divemesh::stereo {
namespace {

// Connected pixels of one row.
struct Run {
    std::int32_t begin;
    std::int32_t end;
};

struct Runs {
    std::vector<Run> all;
    std::vector<std::size_t> first_of_row{0};  // and the end of the last row
};

bool together(float a, float b, float max_step_px) {
    return a > 0.0F && b > 0.0F && std::abs(a - b) <= max_step_px;
}

Runs find_runs(const cv::Mat& disparity_px, float max_step_px) {
    Runs runs;
    for (int y = 0; y < disparity_px.rows; ++y) {
        const float* row = disparity_px.ptr<float>(y);
        for (std::int32_t x = 0; x < disparity_px.cols; ++x) {
            if (row[x] <= 0.0F) continue;
            const std::int32_t begin = x;
            while (x + 1 < disparity_px.cols && together(row[x], row[x + 1], max_step_px)) ++x;
            runs.all.push_back({begin, x + 1});
        }
        runs.first_of_row.push_back(runs.all.size());
    }
    return runs;
}

// Joins the runs of one row with those of the row above.
void join_runs(const cv::Mat& disparity_px,
               float max_step_px,
               const Runs& runs,
               int y,
               base::DisjointSets& sets) {
    const float* row = disparity_px.ptr<float>(y);
    const float* above = disparity_px.ptr<float>(y - 1);
    std::size_t a = runs.first_of_row[y - 1];
    std::size_t b = runs.first_of_row[y];
    while (a < runs.first_of_row[y] && b < runs.first_of_row[y + 1]) {
        const std::int32_t end = std::min(runs.all[a].end, runs.all[b].end);
        for (std::int32_t x = std::max(runs.all[a].begin, runs.all[b].begin); x < end; ++x)
            if (together(row[x], above[x], max_step_px)) {
                sets.join(a, b);
                break;
            }
        if (runs.all[a].end == end)
            ++a;
        else
            ++b;
    }
}

// Calls change(first disparity, number of them) for each run of a small island.
template <typename Change>
void for_each_speckle(cv::Mat& disparity_px,
                      int min_pixels,
                      float max_step_px,
                      const Change& change) {
    const Runs runs = find_runs(disparity_px, max_step_px);
    base::DisjointSets sets(runs.all.size());
    for (int y = 1; y < disparity_px.rows; ++y) join_runs(disparity_px, max_step_px, runs, y, sets);
    std::vector<std::int32_t> size(runs.all.size(), 0);
    for (std::size_t i = 0; i < runs.all.size(); ++i)
        size[sets.find(i)] += runs.all[i].end - runs.all[i].begin;
    for (int y = 0; y < disparity_px.rows; ++y)
        for (std::size_t i = runs.first_of_row[y]; i < runs.first_of_row[y + 1]; ++i)
            if (size[sets.find(i)] < min_pixels)
                change(disparity_px.ptr<float>(y) + runs.all[i].begin,
                       runs.all[i].end - runs.all[i].begin);
}

}  // namespace

void remove_speckles(cv::Mat& disparity_px, int min_pixels, float max_step_px) {
    for_each_speckle(disparity_px, min_pixels, max_step_px, [](float* first, int num) {
        std::fill_n(first, num, 0.0F);
    });
}

void unconfirm_speckles(cv::Mat& disparity_px, int min_pixels, float max_step_px) {
    for_each_speckle(disparity_px, min_pixels, max_step_px, [](float* first, int num) {
        for (int i = 0; i < num; ++i) first[i] = -first[i];
    });
}

}  // namespace divemesh::stereo
