#include "worker/recording/paired_video.hpp"

#include <opencv2/core.hpp>
#include <string_view>

#include "worker/recording/messages.hpp"

namespace divemesh::recording {
namespace {

// Returns one of the halves of an image as an image of its own.
cv::Mat half_of(const cv::Mat& image, VideoLayout layout, int half) {
    const cv::Size size = layout == VideoLayout::SideBySide ? cv::Size(image.cols / 2, image.rows)
                                                            : cv::Size(image.cols, image.rows / 2);
    const cv::Point corner = layout == VideoLayout::SideBySide ? cv::Point(half * size.width, 0)
                                                               : cv::Point(0, half * size.height);
    return image(cv::Rect(corner, size)).clone();
}

std::vector<std::int64_t> stamps_of(const std::vector<video::PlannedPair>& plan,
                                    std::int64_t video::PlannedPair::*side) {
    std::vector<std::int64_t> stamps_ns;
    stamps_ns.reserve(plan.size());
    for (const video::PlannedPair& pair : plan) stamps_ns.push_back(pair.*side);
    return stamps_ns;
}

}  // namespace

PairedVideo::PairedVideo(const std::vector<video::IndexedVideo>& videos,
                         VideoLayout layout,
                         const std::vector<video::PlannedPair>& plan)
    : layout_(layout) {
    const auto stored_jpeg =
        layout == VideoLayout::TwoFiles ? video::StoredJpeg::Kept : video::StoredJpeg::Decoded;
    left_ = std::make_unique<video::JoinedReader>(
        videos.front().parts, stamps_of(plan, &video::PlannedPair::left_ns), stored_jpeg);
    if (layout == VideoLayout::TwoFiles)
        right_ = std::make_unique<video::JoinedReader>(
            videos.back().parts, stamps_of(plan, &video::PlannedPair::right_ns), stored_jpeg);
}

std::optional<VideoPair> PairedVideo::at(const video::PlannedPair& pair) {
    auto left = left_->at(pair.left_ns);
    if (right_ == nullptr) {
        if (!left) return std::nullopt;
        return VideoPair{pair,
                         {pair.left_ns, half_of(left->pixels, layout_, 0), {}},
                         {pair.left_ns, half_of(left->pixels, layout_, 1), {}}};
    }
    auto right = right_->at(pair.right_ns);
    if (!left || !right) return std::nullopt;
    return VideoPair{pair, std::move(*left), std::move(*right)};
}

ImageFile image_file(const video::VideoFrame& frame) {
    if (!frame.jpeg.empty()) return image_file(CompressedImage{{}, "jpeg", frame.jpeg});
    const cv::Mat& pixels = frame.pixels;
    RawImage image;
    image.width_px = static_cast<std::uint32_t>(pixels.cols);
    image.height_px = static_cast<std::uint32_t>(pixels.rows);
    image.encoding = pixels.channels() == 1 ? "mono8" : "bgr8";
    image.row_bytes = static_cast<std::uint32_t>(pixels.step[0]);
    image.pixels = std::string_view(reinterpret_cast<const char*>(pixels.data),
                                    pixels.step[0] * static_cast<std::size_t>(pixels.rows));
    return image_file(image);
}

}  // namespace divemesh::recording
