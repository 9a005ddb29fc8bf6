#pragma once

#include <opencv2/core/mat.hpp>

#include "worker/video/libav.hpp"

namespace divemesh::video {

// Turns decoded frames into 8 bit grey or BGR, by the colour space and range that they state.
// Formats of 8 bit grey and RGB keep their values. For one thread at a time.
class FrameConverter {
public:
    // `rotation_deg`, a multiple of 90, turns the result clockwise. Returns an empty image if the
    // format is one that libswscale does not read.
    cv::Mat convert(const AVFrame& frame, int rotation_deg);

private:
    bool prepare(const AVFrame& frame, AVPixelFormat target);

    ScalerHandle scaler_;
};

}  // namespace divemesh::video
