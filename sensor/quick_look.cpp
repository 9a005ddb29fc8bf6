#include "sensor/quick_look.hpp"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <optional>
#include <vector>

#include "sensor/rig_file.hpp"
#include "worker/tracking/corner_scores.hpp"

namespace divemesh::sensor {
namespace {

constexpr int kGridColumns = 8;
constexpr int kGridRows = 6;
constexpr int kCell_px = 32;
constexpr float kLeastCorner = 20.0F;  // well above noise

cv::Mat grey_of(const cv::Mat& picture) {
    if (picture.empty() || picture.channels() == 1) return picture;
    cv::Mat grey;
    cv::cvtColor(picture, grey, cv::COLOR_BGR2GRAY);
    return grey;
}

double coverage(const std::vector<cv::Point2d>& points, cv::Size size) {
    std::vector<bool> cells(kGridColumns * kGridRows, false);
    for (const cv::Point2d& point : points) {
        const int u = static_cast<int>(point.x * kGridColumns / size.width);
        const int v = static_cast<int>(point.y * kGridRows / size.height);
        if (u >= 0 && v >= 0 && u < kGridColumns && v < kGridRows)
            cells[static_cast<std::size_t>(v * kGridColumns + u)] = true;
    }
    return static_cast<double>(std::count(cells.begin(), cells.end(), true)) /
           static_cast<double>(cells.size());
}

// What a person wants to read of a figure, and what a thin link has to carry.
double rounded(double value) { return std::round(value * 1000.0) / 1000.0; }

bool fits(const cv::Mat& picture, const worker::Camera& camera) {
    return picture.cols == camera.width_px && picture.rows == camera.height_px;
}

}  // namespace

struct QuickLook::Implementation {
    std::optional<worker::Rig> rig;
    std::optional<QuickOdometry> odometry;
    worker::CornerScores corners;
    std::vector<cv::Point2d> points;  // in the last picture
    PictureQuality quality;
    cv::Mat picture;
    int num_frames = 0;

    void follow(const FramePictures& before, const FramePictures& now) {
        if (!odometry) odometry.emplace(*rig);
        const auto stereo = [this](const FramePictures& frame) {
            return worker::StereoFrame{
                num_frames, frame.timestamp_ns, grey_of(frame.left), grey_of(frame.right)};
        };
        odometry->add(stereo(before), stereo(now));
        for (const worker::Feature& feature : odometry->features())
            points.emplace_back(feature.pixel.x(), feature.pixel.y());
        picture = odometry->picture();
    }
    bool fits(const FramePictures& frame) const {
        return rig && sensor::fits(frame.left, rig->cam0) && sensor::fits(frame.right, rig->cam1);
    }
    void count(const cv::Mat& left) {
        for (const cv::Point& point : worker::best_of_cells(
                 corners.of(left), kLeastCorner, worker::CornerScores::kBorder_px, kCell_px))
            points.emplace_back(point);
        picture = left;
    }
};

QuickLook::QuickLook(const std::filesystem::path& dive_root)
    : implementation_(std::make_unique<Implementation>()) {
    implementation_->rig = read_rig(dive_root);
}

QuickLook::~QuickLook() = default;

void QuickLook::look(const FramePictures& before,
                     const FramePictures& now,
                     const PictureQuality& quality) {
    auto& own = *implementation_;
    own.quality = quality;
    own.points.clear();
    if (own.fits(before) && own.fits(now) && before.timestamp_ns < now.timestamp_ns)
        own.follow(before, now);
    else
        own.count(grey_of(now.left));
    ++own.num_frames;
}

nlohmann::json QuickLook::report() const {
    const auto& own = *implementation_;
    if (own.num_frames == 0) return nullptr;
    nlohmann::json report = {{"features", own.points.size()},
                             {"coverage", rounded(coverage(own.points, own.picture.size()))},
                             {"mean_level", rounded(own.quality.mean_level)},
                             {"black", rounded(own.quality.black_share)},
                             {"bright", rounded(own.quality.bright_share)}};
    if (own.quality.sharpness) report["sharpness"] = rounded(*own.quality.sharpness);
    if (!own.odometry) return report;
    report["tracked"] = own.odometry->num_tracked();
    report["distance_m"] = rounded(own.odometry->distance_m());
    report["expected_drift_m"] = rounded(own.odometry->expected_drift_m());
    report["pairs"] = own.odometry->num_looks();
    report["lost"] = own.odometry->num_lost();
    return report;
}

const QuickOdometry* QuickLook::odometry() const {
    return implementation_->odometry ? &*implementation_->odometry : nullptr;
}

cv::Mat QuickLook::picture() const { return implementation_->picture; }

const std::vector<TrackLine>& QuickLook::tracks() const {
    static const std::vector<TrackLine> kNone;
    return implementation_->odometry ? implementation_->odometry->tracks() : kNone;
}

}  // namespace divemesh::sensor
