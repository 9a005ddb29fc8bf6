// Step 1. `DE` is one disparity of one pixel evaluated.
#include <benchmark/benchmark.h>
#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>

#include "tests/bench/kernel_images.hpp"
#include "tests/bench/measured.hpp"
#include "worker/stereo/block_matcher.hpp"
#include "worker/stereo/census_sgm.hpp"
#include "worker/stereo/combine_scales.hpp"
#include "worker/stereo/disparity_doubt.hpp"
#include "worker/stereo/refine_disparity.hpp"
#include "worker/stereo/search_tiles.hpp"
#include "worker/stereo/speckles.hpp"

namespace divemesh::bench {
namespace {

using base::best_instructions;
using base::Instructions;

constexpr double kNumPixels = 1.0 * kWidth_px * kHeight_px;

// Operations on vectors of bytes that semi-global matching cannot do without, per pixel and vector
// of disparities (worker/stereo/sgm_rows.simd.hpp): the census distance; five paths of six
// operations and the least of each; four sums; the least sum, where it is and what comes near it.
double num_operations(Instructions instructions) {
    constexpr double kPaths = 5 * (6 + 1) + 4 + 1 + 3;
    switch (instructions) {
        case Instructions::Avx512: return 11 + kPaths;  // counts bits by itself
        case Instructions::Avx2: return 29 + kPaths;    // by table, three planes added first
        case Instructions::Baseline: break;
    }
    return 41 + kPaths;  // by shifts
}

template <typename Run>
double measure_range(benchmark::State& state, Run&& run) {
    return measure(state, "DE", kNumPixels * static_cast<double>(state.range(0)), run);
}

void opencv_3way(benchmark::State& state) {
    const auto matcher = cv::StereoSGBM::create(0,
                                                static_cast<int>(state.range(0)),
                                                5,
                                                200,
                                                800,
                                                1,
                                                0,
                                                5,
                                                0,
                                                0,
                                                cv::StereoSGBM::MODE_SGBM_3WAY);
    cv::Mat disparity;
    measure_range(state,
                  [&] { matcher->compute(slanted_bed().left, slanted_bed().right, disparity); });
}

void opencv_block(benchmark::State& state) {
    const auto matcher = cv::StereoBM::create(static_cast<int>(state.range(0)), 11);
    cv::Mat disparity;
    measure_range(state,
                  [&] { matcher->compute(slanted_bed().left, slanted_bed().right, disparity); });
}

// `of_limit`: how much of what this core does in vector operations at most is spent on those that
// are needed.
void census_sgm(benchmark::State& state) {
    const auto set = static_cast<Instructions>(state.range(1));
    stereo::CensusSgm matcher(static_cast<int>(state.range(0)), set);
    const double run_s = measure_range(state, [&] {
        benchmark::DoNotOptimize(matcher.compute(slanted_bed().left, slanted_bed().right));
    });
    const double needed = kNumPixels * static_cast<double>(state.range(0)) * num_operations(set);
    state.counters["of_limit"] = needed / byte_operations_per_s(set) / run_s;
}

void census_sgm_refined(benchmark::State& state) {
    const auto set = static_cast<Instructions>(state.range(1));
    stereo::CensusSgm matcher(static_cast<int>(state.range(0)), set);
    stereo::DisparityRefiner refiner(set);
    measure_range(state, [&] {
        cv::Mat disparity = matcher.compute(slanted_bed().left, slanted_bed().right);
        stereo::unconfirm_speckles(disparity, 120, 1.5F);
        benchmark::DoNotOptimize(
            refiner.refine(slanted_bed().left, slanted_bed().right, disparity));
        stereo::remove_speckles(disparity, 120, 1.5F);
    });
}

// A pair of 1920 x 1440 px and 448 disparities: the whole range, or by tiles as half the size
// tells, with the time for that half.
constexpr int kLargeRange_px = 448;

ImagePair large_bed() {
    ImagePair pair;
    cv::resize(slanted_bed().left, pair.left, {}, 3.0, 3.0, cv::INTER_CUBIC);
    cv::resize(slanted_bed().right, pair.right, {}, 3.0, 3.0, cv::INTER_CUBIC);
    return pair;
}

ImagePair halved(const ImagePair& pair) {
    ImagePair half;
    cv::resize(pair.left, half.left, {}, 0.5, 0.5, cv::INTER_AREA);
    cv::resize(pair.right, half.right, {}, 0.5, 0.5, cv::INTER_AREA);
    return half;
}

void large_whole(benchmark::State& state) {
    const ImagePair pair = large_bed();
    stereo::CensusSgm matcher(kLargeRange_px);
    measure(state, "px", 9.0 * kNumPixels, [&] {
        benchmark::DoNotOptimize(matcher.compute(pair.left, pair.right));
    });
}

void large_by_tiles(benchmark::State& state) {
    const ImagePair pair = large_bed();
    stereo::CensusSgm matcher(kLargeRange_px);
    stereo::CensusSgm half_matcher(kLargeRange_px / 2);
    measure(state, "px", 9.0 * kNumPixels, [&] {
        const ImagePair half = halved(pair);
        cv::Mat seen = cv::max(half_matcher.compute(half.left, half.right), 0.0);
        stereo::remove_speckles(seen, 120, 1.5F);
        benchmark::DoNotOptimize(
            matcher.compute(pair.left,
                            pair.right,
                            stereo::search_tiles(seen, pair.left.size(), {0, kLargeRange_px}),
                            stereo::CensusSgm::kMinTolerance));
    });
}

void block_matcher(benchmark::State& state) {
    stereo::BlockMatcher matcher(static_cast<int>(state.range(0)),
                                 static_cast<Instructions>(state.range(1)));
    measure_range(state, [&] {
        benchmark::DoNotOptimize(matcher.compute(slanted_bed().left, slanted_bed().right));
    });
}

// Ranges times the instruction sets that this machine runs.
void every_set(benchmark::internal::Benchmark* benchmark) {
    for (const int range : {64, 128})
        for (int set = 0; set <= static_cast<int>(best_instructions()); ++set)
            benchmark->Args({range, set});
    benchmark->ArgNames({"range", "set"})->Unit(benchmark::kMillisecond);
}

cv::Mat matched_bed() {
    return cv::max(stereo::CensusSgm(128).compute(slanted_bed().left, slanted_bed().right), 0.0);
}

void speckles(benchmark::State& state) {
    const cv::Mat matched = matched_bed();
    measure(state, "px", kNumPixels, [&] {
        cv::Mat disparity = matched.clone();
        stereo::remove_speckles(disparity, 120, 1.5F);
    });
}

void opencv_speckles(benchmark::State& state) {
    cv::Mat matched, buffer;
    matched_bed().convertTo(matched, CV_16S, 16.0);
    measure(state, "px", kNumPixels, [&] {
        cv::Mat disparity = matched.clone();
        cv::filterSpeckles(disparity, 0, 120, 24, buffer);
    });
}

types::DepthMap refined_depth(const ImagePair& pair, int num_disparities) {
    types::DepthMap depth;
    depth.disparity_px = stereo::CensusSgm(num_disparities).compute(pair.left, pair.right);
    depth.sigma_disparity_px =
        stereo::DisparityRefiner().refine(pair.left, pair.right, depth.disparity_px);
    return depth;
}

void combine_scales(benchmark::State& state) {
    const types::DepthMap half = refined_depth(halved(slanted_bed()), 64);
    const types::DepthMap full = refined_depth(slanted_bed(), 128);
    measure(state, "px", kNumPixels, [&] {
        types::DepthMap depth{full.disparity_px.clone(), full.sigma_disparity_px.clone()};
        stereo::combine_scales(half, depth, static_cast<Instructions>(state.range(0)));
        benchmark::DoNotOptimize(depth);
    });
}

void add_doubt(benchmark::State& state) {
    const cv::Mat winners = stereo::CensusSgm(128).compute(slanted_bed().left, slanted_bed().right);
    cv::Mat sigma(winners.size(), CV_32F, cv::Scalar(0.2));
    measure(state, "px", kNumPixels, [&] {
        stereo::add_doubt(winners, sigma, static_cast<Instructions>(state.range(0)));
    });
}

// The instruction sets that this machine runs and loops are compiled for.
void every_loop(benchmark::internal::Benchmark* benchmark) {
    benchmark->Arg(static_cast<int>(Instructions::Baseline));
    if (best_instructions() != Instructions::Baseline)
        benchmark->Arg(static_cast<int>(Instructions::Avx2));
    benchmark->ArgNames({"set"})->Unit(benchmark::kMillisecond);
}

BENCHMARK(opencv_3way)->Arg(64)->Arg(128)->Unit(benchmark::kMillisecond);
BENCHMARK(census_sgm)->Apply(every_set);
BENCHMARK(census_sgm_refined)->Apply(every_set);
BENCHMARK(large_whole)->Unit(benchmark::kMillisecond);
BENCHMARK(large_by_tiles)->Unit(benchmark::kMillisecond);
BENCHMARK(opencv_block)->Arg(64)->Arg(128)->Unit(benchmark::kMillisecond);
BENCHMARK(block_matcher)->Apply(every_set);
BENCHMARK(opencv_speckles)->Unit(benchmark::kMillisecond);
BENCHMARK(speckles)->Unit(benchmark::kMillisecond);
BENCHMARK(combine_scales)->Apply(every_loop);
BENCHMARK(add_doubt)->Apply(every_loop);

}  // namespace
}  // namespace divemesh::bench
