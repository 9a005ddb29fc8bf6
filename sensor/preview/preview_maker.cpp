#include "sensor/preview/preview_maker.hpp"

#include <algorithm>
#include <cmath>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "schemas/error.hpp"

namespace divemesh::sensor {
namespace {

constexpr double kPreviewSeconds = 3.0;
constexpr std::int64_t kUnknownRateBytes = std::int64_t{24} << 10;
constexpr std::int64_t kMinPreviewBytes = std::int64_t{4} << 10;
constexpr double kFirstBitsPerPixel = 1.0;  // of a JPEG at the best quality below
constexpr int kQualities[] = {75, 55, 40};
constexpr int kMaxWidth_px = 1280;  // of one camera on a screen
constexpr double kSmaller = 0.75;
constexpr int kMinWidth_px = 16;

}  // namespace

std::string_view to_string(View view) {
    return view == View::Left ? "cam0" : view == View::Right ? "cam1" : "pair";
}

std::int64_t preview_budget(double bytes_per_s) {
    if (bytes_per_s <= 0.0) return kUnknownRateBytes;
    const double bytes = std::min(kPreviewSeconds * bytes_per_s, 1e9);
    return std::clamp(static_cast<std::int64_t>(bytes), kMinPreviewBytes, kMaxPreviewBytes);
}

cv::Mat image_of(const FrameImages& frame, View view) {
    if (view == View::Left) return frame.left;
    if (view == View::Right || frame.right.empty()) return frame.right;
    cv::Mat right = frame.right;
    if (right.channels() != frame.left.channels())
        cv::cvtColor(frame.right,
                     right,
                     frame.left.channels() == 1 ? cv::COLOR_BGR2GRAY : cv::COLOR_GRAY2BGR);
    if (right.rows != frame.left.rows) cv::resize(cv::Mat(right), right, frame.left.size());
    cv::Mat pair;
    cv::hconcat(frame.left, right, pair);
    return pair;
}

Preview make_preview(const cv::Mat& image, std::int64_t max_bytes) {
    const auto budget = static_cast<double>(std::min(max_bytes, kMaxPreviewBytes));
    const auto pixels = static_cast<double>(image.total());
    const bool is_pair = image.cols > 2 * image.rows;
    const double widest = (is_pair ? 2.0 : 1.0) * kMaxWidth_px / image.cols;
    double scale = std::min({1.0, widest, std::sqrt(8.0 * budget / (kFirstBitsPerPixel * pixels))});
    std::vector<std::uint8_t> jpeg;
    for (; scale * image.cols >= kMinWidth_px; scale *= kSmaller) {
        cv::Mat scaled = image;
        if (scale < 1.0) cv::resize(image, scaled, {}, scale, scale, cv::INTER_AREA);
        for (const int quality : kQualities) {
            cv::imencode(".jpg", scaled, jpeg, {cv::IMWRITE_JPEG_QUALITY, quality});
            if (static_cast<double>(jpeg.size()) <= budget)
                return {std::string(jpeg.begin(), jpeg.end()), scaled.cols, scaled.rows};
        }
    }
    throw Error(ErrorCode::TooLarge,
                "a preview cannot be made with at most " + std::to_string(max_bytes) +
                    " bytes: allow more");
}

cv::Mat with_tracks(const cv::Mat& image, std::span<const TrackLine> tracks) {
    cv::Mat drawn;
    if (image.channels() == 1)
        cv::cvtColor(image, drawn, cv::COLOR_GRAY2BGR);
    else
        drawn = image.clone();
    for (const TrackLine& track : tracks) {
        cv::line(drawn, track.from, track.to, {0, 200, 255}, 1, cv::LINE_AA);
        cv::circle(drawn, track.to, 2, {0, 255, 0}, cv::FILLED, cv::LINE_AA);
    }
    return drawn;
}

}  // namespace divemesh::sensor
