// Step 2.
#include <benchmark/benchmark.h>
#include <opencv2/imgproc.hpp>
#include <opencv2/video/tracking.hpp>

#include "tests/bench/kernel_images.hpp"
#include "tests/bench/measured.hpp"
#include "worker/features/align_patch.hpp"
#include "worker/features/corner_scores.hpp"

namespace divemesh::bench {
namespace {

constexpr double kNumPixels = 1.0 * kWidth_px * kHeight_px;
constexpr float kMove_px = 0.7F;  // of the image, along both axes

struct Move {
    cv::Mat before;
    cv::Mat now;
    std::vector<cv::Point2f> features;
};

const Move& small_move() {
    static const Move made = [] {
        Move move;
        move.before = slanted_bed().left;
        const cv::Matx23f shift(1.0F, 0.0F, kMove_px, 0.0F, 1.0F, kMove_px);
        cv::warpAffine(move.before, move.now, shift, move.before.size());
        cv::goodFeaturesToTrack(move.before, move.features, 300, 0.01, 15.0);
        return move;
    }();
    return made;
}

// One level of the pyramid, as one call of ours: the image hardly moves.
void opencv_klt(benchmark::State& state) {
    const Move& move = small_move();
    std::vector<cv::Point2f> found;
    std::vector<std::uint8_t> status;
    std::vector<float> error;
    measure(state, "feature", static_cast<double>(move.features.size()), [&] {
        cv::calcOpticalFlowPyrLK(
            move.before, move.now, move.features, found, status, error, {16, 16}, 0);
    });
}

void align_patch(benchmark::State& state) {
    const Move& move = small_move();
    measure(state, "feature", static_cast<double>(move.features.size()), [&] {
        for (const cv::Point2f& feature : move.features) {
            const Eigen::Vector2d pixel(feature.x, feature.y);
            const auto patch = features::Patch::read(move.before, pixel);
            if (patch) benchmark::DoNotOptimize(patch->align(move.now, pixel));
        }
    });
}

void opencv_corners(benchmark::State& state) {
    cv::Mat scores;
    measure(
        state, "px", kNumPixels, [&] { cv::cornerMinEigenVal(slanted_bed().left, scores, 5, 3); });
}

void corner_scores(benchmark::State& state) {
    features::CornerScores scores;
    measure(
        state, "px", kNumPixels, [&] { benchmark::DoNotOptimize(scores.of(slanted_bed().left)); });
}

BENCHMARK(opencv_klt)->Unit(benchmark::kMillisecond);
BENCHMARK(align_patch)->Unit(benchmark::kMillisecond);
BENCHMARK(opencv_corners)->Unit(benchmark::kMillisecond);
BENCHMARK(corner_scores)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace divemesh::bench
