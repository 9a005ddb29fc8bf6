#include "tests/bench/stereo_coverage.hpp"

#include <algorithm>
#include <cstdio>
#include <ctime>
#include <opencv2/calib3d.hpp>
#include <opencv2/core/utility.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <string>

#include "schemas/reconstruction_options.hpp"
#include "tests/temporary_folder.hpp"
#include "worker/calibration/stereo_alignment.hpp"
#include "worker/camera/rectifier.hpp"
#include "worker/dive/dive.hpp"
#include "worker/pipeline/align_cameras.hpp"
#include "worker/stereo/match_stereo.hpp"

namespace divemesh::bench {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

double cpu_ms() {
    timespec now{};
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
    return 1e3 * static_cast<double>(now.tv_sec) + 1e-6 * static_cast<double>(now.tv_nsec);
}

class Opencv3Way {
public:
    explicit Opencv3Way(int num_disparities)
        : matcher_(cv::StereoSGBM::create(
              0, num_disparities, 5, 200, 800, 1, 0, 10, 100, 2, cv::StereoSGBM::MODE_SGBM_3WAY)) {}
    cv::Mat match(const types::RectifiedFrame& frame) const {
        cv::Mat fixed_point;
        cv::Mat disparity;
        matcher_->compute(frame.left, frame.right, fixed_point);
        fixed_point.convertTo(disparity, CV_32F, 1.0 / 16.0);
        return disparity;
    }

private:
    cv::Ptr<cv::StereoSGBM> matcher_;
};

double share_known(const cv::Mat& disparity_px, int first_column) {
    const cv::Mat counted = disparity_px.colRange(first_column, disparity_px.cols);
    return static_cast<double>(cv::countNonZero(counted > 0.0F)) /
           static_cast<double>(counted.total());
}

cv::Mat in_colors(const cv::Mat& disparity_px, int num_disparities) {
    cv::Mat grey;
    cv::Mat colors;
    disparity_px.convertTo(grey, CV_8U, 255.0 / num_disparities);
    cv::applyColorMap(grey, colors, cv::COLORMAP_TURBO);
    colors.setTo(cv::Scalar::all(0.0), disparity_px <= 0.0F);
    return colors;
}

// Left image, our disparity, its sigma up to 4 px, and OpenCV's disparity.
void write_image(const fs::path& file,
                 const types::RectifiedFrame& frame,
                 const types::DepthMap& own,
                 const cv::Mat& rival,
                 int num_disparities) {
    cv::Mat left;
    cv::cvtColor(frame.left, left, cv::COLOR_GRAY2BGR);
    cv::Mat above;
    cv::Mat below;
    cv::hconcat(left, in_colors(own.disparity_px, num_disparities), above);
    cv::hconcat(in_colors(own.sigma_disparity_px, 4), in_colors(rival, num_disparities), below);
    cv::Mat all;
    cv::vconcat(above, below, all);
    fs::create_directories(file.parent_path());
    cv::imwrite(file.string(), all);
}

}  // namespace

json compare_coverage(const fs::path& dive, const CoverageOptions& options) {
    cv::setNumThreads(1);
    const TemporaryFolder scratch;
    const auto opened = dive::Dive::open(dive, scratch.path());
    types::Rig rig = opened->rig();
    const auto alignment = pipeline::align_cameras(*opened, 1, base::ignore_progress);
    if (alignment.outcome == types::RigAlignment::Outcome::Moved)
        rig = calibration::changed_rig(rig, alignment.change);
    const camera::Rectifier rectifier(rig);
    stereo::StereoMatcher matcher(
        "sgm", options.num_disparities_px, ReconstructionOptions().stereo_scales);
    const Opencv3Way opencv(options.num_disparities_px);
    double own_ms = 0.0;
    double rival_ms = 0.0;
    double own_share = 0.0;
    double rival_share = 0.0;
    json pairs = json::array();
    for (int i = 0; i < options.num_pairs; ++i) {
        const int index = (2 * i + 1) * opened->num_frames() / (2 * options.num_pairs);
        const auto recorded = opened->frame(index);
        if (!recorded) continue;
        const types::RectifiedFrame frame = rectifier.rectify(*recorded);
        const double start = cpu_ms();
        const types::DepthMap own = matcher.match(frame);
        const double between = cpu_ms();
        const cv::Mat rival = opencv.match(frame);
        rival_ms += cpu_ms() - between;
        own_ms += between - start;
        const int first = std::min(options.num_disparities_px, frame.left.cols / 2);
        pairs.push_back({{"frame", index},
                         {"own", share_known(own.disparity_px, first)},
                         {"own_whole_image", share_known(own.disparity_px, 0)},
                         {"sgbm", share_known(rival, first)}});
        own_share += pairs.back()["own"].get<double>();
        rival_share += pairs.back()["sgbm"].get<double>();
        if (!options.images.empty())
            write_image(
                options.images / (dive.filename().string() + "_" + std::to_string(index) + ".png"),
                frame,
                own,
                rival,
                options.num_disparities_px);
    }
    const auto num = static_cast<double>(std::max<std::size_t>(1, pairs.size()));
    return {{"dive", dive.filename().string()},
            {"size_px", {rectifier.rig().width_px, rectifier.rig().height_px}},
            {"own", own_share / num},
            {"sgbm", rival_share / num},
            {"own_to_sgbm", own_share / std::max(1e-9, rival_share)},
            {"own_cpu_ms", own_ms / num},
            {"sgbm_cpu_ms", rival_ms / num},
            {"pairs", pairs}};
}

}  // namespace divemesh::bench
