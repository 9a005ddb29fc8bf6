#include "worker/dive/image_survey.hpp"

#include <algorithm>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <vector>

namespace divemesh::dive {
namespace {

constexpr int kThumbnailWidth_px = 320;
constexpr double kBlackLevel = 2.0;  // of 255, mean over the image

bool is_black(const cv::Mat& image) { return cv::mean(image)[0] < kBlackLevel; }

void report_black(const std::string& camera,
                  std::int64_t num_black,
                  std::int64_t num_frames,
                  FindingLog& findings) {
    const std::string share = std::to_string(num_black) + " of " + std::to_string(num_frames);
    const std::string folder = "mav0/" + camera + "/data";
    if (num_black == num_frames)
        findings.error(
            "images_black",
            folder,
            "all images of " + camera + " are black (" + share + ")",
            "Check lens cap, exposure and lights, and scale 10- and 12-bit data to 8 bits.");
    else if (num_black * 4 > num_frames)
        findings.warning("images_dark",
                         folder,
                         share + " images of " + camera + " are black",
                         "Check exposure and lights.");
}

}  // namespace

void ImageSurvey::add(const types::StereoFrame& frame) {
    ++num_frames_;
    num_black_left_ += is_black(frame.left) ? 1 : 0;
    num_black_right_ += is_black(frame.right) ? 1 : 0;
    if (!nearest_ || *nearest_ < middle_) nearest_ = frame.index;
}

void ImageSurvey::report(std::int64_t num_frames, FindingLog& findings) const {
    if (num_frames_ == 0) {
        if (num_frames > 0)
            findings.error("no_frame_decodes",
                           "mav0/cam0/data",
                           "none of the " + std::to_string(num_frames) + " frames can be used",
                           "Copy the recording from the recorder again.");
        return;
    }
    report_black("cam0", num_black_left_, num_frames_, findings);
    report_black("cam1", num_black_right_, num_frames_, findings);
}

ImageSurvey survey_images(types::Recording& recording, const base::ProgressCallback& progress) {
    ImageSurvey survey(recording.num_frames());
    Progress state;
    state.num_frames = recording.num_frames();
    while (const auto frame = recording.next_frame()) {
        survey.add(*frame);
        state.frames_done = frame->index + 1;
        state.fraction =
            static_cast<double>(state.frames_done) / static_cast<double>(state.num_frames);
        progress(state);
    }
    return survey;
}

std::string thumbnail_jpeg(const cv::Mat& image) {
    const int width = std::min(kThumbnailWidth_px, image.cols);
    const int height = std::max(1, image.rows * width / image.cols);
    cv::Mat small;
    cv::resize(image, small, {width, height}, 0, 0, cv::INTER_AREA);
    std::vector<unsigned char> bytes;
    cv::imencode(".jpg", small, bytes, {cv::IMWRITE_JPEG_QUALITY, 85});
    return {bytes.begin(), bytes.end()};
}

}  // namespace divemesh::dive
