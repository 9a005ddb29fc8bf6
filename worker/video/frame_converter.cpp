#include "worker/video/frame_converter.hpp"

#include <opencv2/core.hpp>

extern "C" {
#include <libavutil/pixdesc.h>
}

namespace divemesh::video {
namespace {

// The fast conversions: half the time of the accurate ones, whose grey values are 1.3 of 255
// brighter everywhere, in both cameras.
constexpr int kFlags = SWS_BILINEAR;
constexpr int kPaddedTo_px = 64;         // libswscale may write this far beyond the end of a row
constexpr int kHighDefinition_px = 720;  // rows; from here on BT.709 if no colour space is stated

bool is_grey(const AVPixFmtDescriptor& format) {
    return format.nb_components <= 2 && (format.flags & (AV_PIX_FMT_FLAG_RGB | AV_PIX_FMT_FLAG_PAL |
                                                         AV_PIX_FMT_FLAG_BAYER)) == 0;
}

bool is_yuv(const AVPixFmtDescriptor& format) {
    return format.nb_components >= 3 && (format.flags & AV_PIX_FMT_FLAG_RGB) == 0;
}

int color_matrix_of(const AVFrame& frame) {
    if (frame.colorspace == AVCOL_SPC_UNSPECIFIED)
        return frame.height >= kHighDefinition_px ? SWS_CS_ITU709 : SWS_CS_ITU601;
    return frame.colorspace;  // libswscale has the same numbers
}

void state_colors(SwsContext& scaler, const AVFrame& frame) {
    int* from = nullptr;
    int* to = nullptr;
    int is_full_from = 0;
    int is_full_to = 0;
    int brightness = 0;
    int contrast = 0;
    int saturation = 0;
    if (sws_getColorspaceDetails(
            &scaler, &from, &is_full_from, &to, &is_full_to, &brightness, &contrast, &saturation) <
        0)
        return;
    if (frame.color_range != AVCOL_RANGE_UNSPECIFIED)
        is_full_from = frame.color_range == AVCOL_RANGE_JPEG ? 1 : 0;
    const int* matrix = sws_getCoefficients(color_matrix_of(frame));
    sws_setColorspaceDetails(
        &scaler, matrix, is_full_from, matrix, is_full_to, brightness, contrast, saturation);
}

cv::Mat turned(const cv::Mat& image, int rotation_deg) {
    if (rotation_deg == 0) return image;
    cv::Mat upright;
    cv::rotate(image,
               upright,
               rotation_deg == 90    ? cv::ROTATE_90_CLOCKWISE
               : rotation_deg == 180 ? cv::ROTATE_180
                                     : cv::ROTATE_90_COUNTERCLOCKWISE);
    return upright;
}

}  // namespace

bool FrameConverter::prepare(const AVFrame& frame, AVPixelFormat target) {
    const auto format = static_cast<AVPixelFormat>(frame.format);
    SwsContext* scaler = sws_getCachedContext(scaler_.release(),
                                              frame.width,
                                              frame.height,
                                              format,
                                              frame.width,
                                              frame.height,
                                              target,
                                              kFlags,
                                              nullptr,
                                              nullptr,
                                              nullptr);
    scaler_.reset(scaler);
    return scaler != nullptr;
}

cv::Mat FrameConverter::convert(const AVFrame& frame, int rotation_deg) {
    const auto* format = av_pix_fmt_desc_get(static_cast<AVPixelFormat>(frame.format));
    if (format == nullptr || (format->flags & AV_PIX_FMT_FLAG_HWACCEL) != 0) return {};
    const bool has_color = !is_grey(*format);
    if (!prepare(frame, has_color ? AV_PIX_FMT_BGR24 : AV_PIX_FMT_GRAY8)) return {};
    if (is_yuv(*format)) state_colors(*scaler_, frame);
    const int padded_px = (frame.width / kPaddedTo_px + 2) * kPaddedTo_px;
    cv::Mat padded(frame.height, padded_px, has_color ? CV_8UC3 : CV_8UC1);
    std::uint8_t* rows[4] = {padded.data, nullptr, nullptr, nullptr};
    const int row_bytes[4] = {static_cast<int>(padded.step[0]), 0, 0, 0};
    if (sws_scale(scaler_.get(), frame.data, frame.linesize, 0, frame.height, rows, row_bytes) !=
        frame.height)
        return {};
    return turned(padded.colRange(0, frame.width), rotation_deg);
}

}  // namespace divemesh::video
