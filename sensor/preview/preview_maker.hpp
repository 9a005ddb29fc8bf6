#pragma once

#include <cstdint>
#include <opencv2/core/mat.hpp>
#include <opencv2/core/types.hpp>
#include <span>
#include <string>
#include <string_view>

#include "sensor/recording/dive_tail.hpp"

namespace divemesh::sensor {

// Which images of a frame to show.
enum class View { Left, Right, Pair };
std::string_view to_string(View view);  // "cam0", "cam1", "pair": names in the stream

struct Preview {
    std::string jpeg;
    int width_px = 0;
    int height_px = 0;
};

inline constexpr std::int64_t kMaxPreviewBytes = std::int64_t{256} << 10;

// Returns the max size of a preview that takes three seconds of a link; 24 KiB if the rate is
// unknown.
std::int64_t preview_budget(double bytes_per_s);

// Returns the image of a view, as recorded; empty if the frame lacks it.
cv::Mat image_of(const FrameImages& frame, View view);

// Returns a JPEG of at most `max_bytes`; reduces first size, then quality. Throws Error{TooLarge}
// if no size is small enough.
Preview make_preview(const cv::Mat& image, std::int64_t max_bytes);

// A tracked feature: its previous and current position, px.
struct TrackLine {
    cv::Point2f from;
    cv::Point2f to;
};
// Returns the image in colour with the tracks drawn over it.
cv::Mat with_tracks(const cv::Mat& image, std::span<const TrackLine> tracks);

}  // namespace divemesh::sensor
