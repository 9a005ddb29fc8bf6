// The inner loops beside their counterparts in OpenCV, on one thread and the same pictures:
//   build/release/tests/bench/divemesh_kernels --benchmark_format=json
// `MDE` is millions of disparities evaluated (pixels times range) per second.
#include <benchmark/benchmark.h>
#include <opencv2/calib3d.hpp>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "worker/stereo/census_sgm.hpp"
#include "worker/stereo/disparity_sigma.hpp"
#include "worker/stereo/refine_disparity.hpp"
#include "worker/stereo/speckles.hpp"

namespace divemesh::worker {
namespace {

constexpr int kWidth_px = 640;
constexpr int kHeight_px = 480;

struct Pair {
    cv::Mat left;
    cv::Mat right;
};

// A slanted bed of random texture, about 20 to 60 px near, with other noise in each picture.
const Pair& slanted_bed() {
    static const Pair pair = [] {
        cv::RNG random(1);
        cv::Mat texture(kHeight_px, kWidth_px + 160, CV_8U);
        random.fill(texture, cv::RNG::UNIFORM, 0, 255);
        cv::GaussianBlur(texture, texture, {7, 7}, 1.5);
        cv::normalize(texture, texture, 0, 255, cv::NORM_MINMAX);
        Pair made;
        made.left = texture(cv::Rect(0, 0, kWidth_px, kHeight_px)).clone();
        cv::Mat x(kHeight_px, kWidth_px, CV_32F);
        cv::Mat y(kHeight_px, kWidth_px, CV_32F);
        for (int v = 0; v < kHeight_px; ++v)
            for (int u = 0; u < kWidth_px; ++u) {
                const auto row = static_cast<float>(v);
                const auto column = static_cast<float>(u);
                x.at<float>(v, u) = column + 20.0F + 0.05F * row + 0.02F * column;
                y.at<float>(v, u) = row;
            }
        cv::remap(texture, made.right, x, y, cv::INTER_LINEAR);
        for (cv::Mat* image : {&made.left, &made.right}) {
            cv::Mat noise(image->size(), CV_8S);
            random.fill(noise, cv::RNG::NORMAL, 0.0, 2.0);
            cv::add(*image, noise, *image, cv::noArray(), CV_8U);
        }
        return made;
    }();
    return pair;
}

void count(benchmark::State& state, std::int64_t num_disparities) {
    const auto evaluated = static_cast<double>(kWidth_px * kHeight_px * num_disparities);
    state.counters["MDE"] =
        benchmark::Counter(1e-6 * evaluated, benchmark::Counter::kIsIterationInvariantRate);
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
    for ([[maybe_unused]] auto _ : state)
        matcher->compute(slanted_bed().left, slanted_bed().right, disparity);
    count(state, state.range(0));
}
BENCHMARK(opencv_3way)->Arg(64)->Arg(128)->Unit(benchmark::kMillisecond);

void census_sgm(benchmark::State& state) {
    CensusSgm matcher(static_cast<int>(state.range(0)), static_cast<Instructions>(state.range(1)));
    for ([[maybe_unused]] auto _ : state)
        benchmark::DoNotOptimize(matcher.compute(slanted_bed().left, slanted_bed().right));
    count(state, state.range(0));
}

void census_sgm_refined(benchmark::State& state) {
    CensusSgm matcher(static_cast<int>(state.range(0)), static_cast<Instructions>(state.range(1)));
    for ([[maybe_unused]] auto _ : state) {
        cv::Mat disparity = matcher.compute(slanted_bed().left, slanted_bed().right);
        remove_speckles(disparity, 120, 1.5F);
        refine_disparity(slanted_bed().left, slanted_bed().right, disparity);
        benchmark::DoNotOptimize(disparity_sigma(slanted_bed().left));
    }
    count(state, state.range(0));
}

// Ranges times the instruction sets that this machine runs.
void every_set(benchmark::internal::Benchmark* benchmark) {
    for (const int range : {64, 128})
        for (int set = 0; set <= static_cast<int>(best_instructions()); ++set)
            benchmark->Args({range, set});
    benchmark->ArgNames({"range", "set"})->Unit(benchmark::kMillisecond);
}
BENCHMARK(census_sgm)->Apply(every_set);
BENCHMARK(census_sgm_refined)->Apply(every_set);

}  // namespace
}  // namespace divemesh::worker

int main(int num_arguments, char** arguments) {
    cv::setNumThreads(1);
    benchmark::Initialize(&num_arguments, arguments);
    if (benchmark::ReportUnrecognizedArguments(num_arguments, arguments)) return 2;
    benchmark::RunSpecifiedBenchmarks();
    benchmark::Shutdown();
    return 0;
}
