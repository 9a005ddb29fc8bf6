#pragma once

#include <cstdint>
#include <opencv2/core/mat.hpp>
#include <opencv2/core/types.hpp>
#include <span>
#include <string>
#include <string_view>

#include "sensor/recording/dive_tail.hpp"

namespace divemesh::sensor {

// What is to be shown of a frame.
enum class View { Left, Right, Pair };
std::string_view to_string(View view);  // "cam0", "cam1", "pair": as the stream names it

struct Preview {
    std::string jpeg;
    int width_px = 0;
    int height_px = 0;
};

inline constexpr std::int64_t kMaxPreviewBytes = std::int64_t{256} << 10;

// How large a preview may be that takes three seconds of a link; 24 KiB where the rate is not
// known.
std::int64_t preview_budget(double bytes_per_s);

// The picture that a view shows, as recorded; empty when the frame does not have it.
cv::Mat image_of(const FrameImages& frame, View view);

// A JPEG of at most `max_bytes`, first smaller, then worse. Throws Error{TooLarge} when no size is
// small enough.
Preview make_preview(const cv::Mat& image, std::int64_t max_bytes);

// A feature that was followed: where it was and is, px.
struct TrackLine {
    cv::Point2f from;
    cv::Point2f to;
};
// The picture in colour with the tracks over it.
cv::Mat with_tracks(const cv::Mat& image, std::span<const TrackLine> tracks);

}  // namespace divemesh::sensor
