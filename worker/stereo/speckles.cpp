#include "worker/stereo/speckles.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include "worker/base/disjoint_sets.hpp"
#include "worker/types/disparity_range.hpp"

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

// Calls change(first disparity, number of them) for each run of a small island. The size of an
// island is the sum of weigh(row, run) over its runs.
template <typename Weigh, typename Change>
void for_each_speckle(cv::Mat& disparity_px,
                      std::int32_t min_size,
                      float max_step_px,
                      const Weigh& weigh,
                      const Change& change) {
    const Runs runs = find_runs(disparity_px, max_step_px);
    base::DisjointSets sets(runs.all.size());
    for (int y = 1; y < disparity_px.rows; ++y) join_runs(disparity_px, max_step_px, runs, y, sets);
    std::vector<std::int64_t> size(runs.all.size(), 0);
    for (int y = 0; y < disparity_px.rows; ++y)
        for (std::size_t i = runs.first_of_row[y]; i < runs.first_of_row[y + 1]; ++i)
            size[sets.find(i)] += weigh(y, runs.all[i]);
    for (int y = 0; y < disparity_px.rows; ++y)
        for (std::size_t i = runs.first_of_row[y]; i < runs.first_of_row[y + 1]; ++i)
            if (size[sets.find(i)] < min_size)
                change(disparity_px.ptr<float>(y) + runs.all[i].begin,
                       runs.all[i].end - runs.all[i].begin);
}

std::int32_t num_pixels(int /*y*/, const Run& run) { return run.end - run.begin; }

void remove_run(float* first, int num) { std::fill_n(first, num, 0.0F); }

}  // namespace

IslandLimits IslandLimits::of(cv::Size image) {
    IslandLimits limits;
    if (image.width <= types::kLargeWidth_px) return limits;
    const double larger = std::max(1.0, image.area() / (640.0 * 480.0));
    limits.min_pixels = static_cast<std::int32_t>(larger * limits.min_pixels);
    limits.min_support.num_pixels =
        static_cast<std::int32_t>(larger * limits.min_support.num_pixels);
    return limits;
}

void remove_speckles(cv::Mat& disparity_px, int min_pixels, float max_step_px) {
    for_each_speckle(disparity_px, min_pixels, max_step_px, num_pixels, remove_run);
}

void remove_unsupported(cv::Mat& disparity_px,
                        const cv::Mat& sigma_px,
                        const IslandSupport& min_support,
                        float max_step_px) {
    const std::int32_t of_certain = min_support.num_pixels / min_support.num_certain;
    const auto weigh = [&](int y, const Run& run) {
        const float* sigmas = sigma_px.ptr<float>(y);
        std::int32_t sum = 0;
        for (std::int32_t x = run.begin; x < run.end; ++x)
            sum += sigmas[x] < min_support.certain_px ? of_certain : 1;
        return std::min(sum, min_support.num_pixels);
    };
    for_each_speckle(disparity_px, min_support.num_pixels, max_step_px, weigh, remove_run);
}

void unconfirm_speckles(cv::Mat& disparity_px, int min_pixels, float max_step_px) {
    const auto unconfirm = [](float* first, int num) {
        for (int i = 0; i < num; ++i) first[i] = -first[i];
    };
    for_each_speckle(disparity_px, min_pixels, max_step_px, num_pixels, unconfirm);
}

}  // namespace divemesh::stereo
