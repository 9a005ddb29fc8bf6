#include "worker/recording/image_pairs.hpp"

#include <algorithm>
#include <cstdlib>
#include <unordered_map>

#include "schemas/error.hpp"
#include "worker/base/seconds.hpp"
#include "worker/base/text.hpp"
#include "worker/dive/stamp_check.hpp"

namespace divemesh::recording {
namespace {

using Rows = std::vector<dive::CameraRow>;

constexpr std::int64_t kSecond_ns = 1'000'000'000;
constexpr double kMinMorePairs = 1.05;              // a share of pairs, not single ones
constexpr std::size_t kMaxDifferences = 4'000'000;  // 32 MB
constexpr std::size_t kMinVoters = 8;

std::int64_t tolerance_ns(const ImageTimes& times) {
    return times.is_in_seconds ? kSecond_ns : dive::common_clock_tolerance_ns(times.left);
}

std::size_t num_pairs(const ImageTimes& times, const dive::ClockDifference& difference) {
    return dive::match_pairs(times.left, times.right, difference, tolerance_ns(times)).size();
}

// Returns the differences between the times of left images, spread over all, and all right ones.
std::vector<std::int64_t> differences_ns(const ImageTimes& times) {
    const std::size_t num_voters =
        std::min(times.left.size(), std::max(kMinVoters, kMaxDifferences / times.right.size()));
    std::vector<std::int64_t> differences;
    differences.reserve(num_voters * times.right.size());
    for (std::size_t i = 0; i < num_voters; ++i) {
        const dive::CameraRow& left = times.left[i * times.left.size() / num_voters];
        for (const dive::CameraRow& right : times.right)
            differences.push_back(right.timestamp_ns - left.timestamp_ns);
    }
    std::sort(differences.begin(), differences.end());
    return differences;
}

// Returns the difference that most images share: the median of the densest window.
dive::ClockDifference voted_difference(const ImageTimes& times) {
    const std::vector<std::int64_t> differences = differences_ns(times);
    const std::int64_t width_ns = 2 * tolerance_ns(times);
    std::size_t best_begin = 0;
    std::size_t best_size = 0;
    for (std::size_t begin = 0, end = 0; begin < differences.size(); ++begin) {
        while (end < differences.size() && differences[end] - differences[begin] <= width_ns) ++end;
        if (end - begin <= best_size) continue;
        best_begin = begin;
        best_size = end - begin;
    }
    dive::ClockDifference voted;
    voted.offset_ns = differences[best_begin + best_size / 2];
    return voted;
}

dive::ClockDifference clock_difference(const ImageTimes& times) {
    if (dive::agree_in_time(times.left, times.right)) return {};
    const auto guess = dive::guess_clock_difference(times.left, times.right);
    const auto voted = voted_difference(times);
    const auto more = kMinMorePairs * static_cast<double>(num_pairs(times, guess));
    const auto& best = static_cast<double>(num_pairs(times, voted)) > more ? voted : guess;
    // Times that are near to each other as they are need no difference.
    const auto least = static_cast<double>(num_pairs(times, best));
    return least > kMinMorePairs * static_cast<double>(num_pairs(times, {}))
               ? best
               : dive::ClockDifference{};
}

void take_off(const dive::ClockDifference& difference, Rows& right) {
    for (dive::CameraRow& row : right) row.timestamp_ns -= difference.offset_ns;
    std::erase_if(right, [](const dive::CameraRow& row) { return row.timestamp_ns < 0; });
}

void report_difference(const dive::ClockDifference& difference, dive::FindingLog& findings) {
    if (difference.is_zero()) return;
    const bool is_ahead = difference.offset_ns > 0;
    findings.warning("camera_clocks_differ",
                     "",
                     "the times of the right camera are " +
                         base::fixed(base::to_s(std::abs(difference.offset_ns)), 3) + " s " +
                         (is_ahead ? "ahead of" : "behind") +
                         " those of the left one; that is taken off, so that most images have a "
                         "partner",
                     "Set the clocks of both cameras before the dive, and look whether the first "
                     "pair shows the same moment.");
}

// Returns the pairs: as near in time as cameras that fire together, or, if many more are found so,
// within half of the time from image to image.
std::vector<dive::FramePair> pairs_of(const ImageTimes& times) {
    const std::int64_t near_ns = tolerance_ns(times);
    auto pairs = dive::match_pairs(times.left, times.right, {}, near_ns);
    if (times.is_in_seconds) return pairs;
    const std::int64_t half_ns = dive::median_period_ns(dive::timestamps_of(times.left)) / 2;
    auto wide = dive::match_pairs(times.left, times.right, {}, std::max(near_ns, half_ns));
    const bool are_more =
        static_cast<double>(wide.size()) > kMinMorePairs * static_cast<double>(pairs.size());
    return are_more ? wide : pairs;
}

void report_pairs_made(const ImageTimes& times,
                       const std::vector<dive::FramePair>& pairs,
                       dive::FindingLog& findings) {
    std::int64_t max_gap_ns = 0;
    for (const dive::FramePair& pair : pairs)
        max_gap_ns = std::max(max_gap_ns, std::abs(pair.right_ns - pair.timestamp_ns));
    findings.info("pairs_made",
                  "",
                  std::to_string(pairs.size()) + " pairs of " + std::to_string(times.left.size()) +
                      " left and " + std::to_string(times.right.size()) + " right images by " +
                      times.source + ", at most " + base::fixed(1e3 * base::to_s(max_gap_ns), 1) +
                      " ms apart");
}

// Returns the images of pairs, both with the time of the left one.
PairedImages at_left_times(const std::vector<dive::FramePair>& pairs) {
    PairedImages images;
    for (const dive::FramePair& pair : pairs) {
        images.left.push_back({pair.timestamp_ns, pair.left});
        images.right.push_back({pair.timestamp_ns, pair.right});
    }
    return images;
}

}  // namespace

PairedImages pair_images(ImageTimes times, dive::FindingLog& findings) {
    const dive::ClockDifference difference = clock_difference(times);
    report_difference(difference, findings);
    take_off(difference, times.right);
    const std::vector<dive::FramePair> pairs = pairs_of(times);
    if (pairs.empty())
        throw Error(ErrorCode::BadData,
                    "no left image has a right one of its time, by " + times.source +
                        ": give a table of time, left and right image by --list, or the images "
                        "per second by --rate");
    report_pairs_made(times, pairs, findings);
    if (times.is_in_seconds) return at_left_times(pairs);
    return {std::move(times.left), std::move(times.right)};
}

}  // namespace divemesh::recording
