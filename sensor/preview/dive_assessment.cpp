#include "sensor/preview/dive_assessment.hpp"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <optional>
#include <vector>

#include "sensor/recording/rig_file.hpp"
#include "worker/features/corner_scores.hpp"

namespace divemesh::sensor {
namespace {

constexpr int kGridColumns = 8;
constexpr int kGridRows = 6;
constexpr int kCell_px = 32;
constexpr float kMinCornerScore = 20.0F;  // well above noise

cv::Mat grey_of(const cv::Mat& image) {
    if (image.empty() || image.channels() == 1) return image;
    cv::Mat grey;
    cv::cvtColor(image, grey, cv::COLOR_BGR2GRAY);
    return grey;
}

double coverage(const std::vector<cv::Point2d>& points, cv::Size size) {
    std::vector<bool> cells(std::size_t{kGridColumns} * kGridRows, false);
    for (const cv::Point2d& point : points) {
        const int u = static_cast<int>(point.x * kGridColumns / size.width);
        const int v = static_cast<int>(point.y * kGridRows / size.height);
        if (u >= 0 && v >= 0 && u < kGridColumns && v < kGridRows)
            cells[static_cast<std::size_t>(v) * kGridColumns + u] = true;
    }
    return static_cast<double>(std::count(cells.begin(), cells.end(), true)) /
           static_cast<double>(cells.size());
}

// Rounds to three decimals: easy to read, and short on a slow link.
double rounded(double value) { return std::round(value * 1000.0) / 1000.0; }

bool fits(const cv::Mat& image, const types::Camera& camera) {
    return image.cols == camera.width_px && image.rows == camera.height_px;
}

}  // namespace

struct DiveAssessment::Implementation {
    std::optional<types::Rig> rig;
    std::optional<LiveOdometry> odometry;
    features::CornerScores corners;
    std::vector<cv::Point2d> points;  // in the last image
    ImageQuality quality;
    cv::Mat image;
    int num_frames = 0;

    void follow(const FrameImages& before, const FrameImages& now) {
        if (!odometry) odometry.emplace(*rig);
        const auto stereo = [this](const FrameImages& frame) {
            return types::StereoFrame{
                num_frames, frame.timestamp_ns, grey_of(frame.left), grey_of(frame.right)};
        };
        odometry->add(stereo(before), stereo(now));
        for (const types::Feature& feature : odometry->features())
            points.emplace_back(feature.pixel.x(), feature.pixel.y());
        image = odometry->image();
    }
    bool fits(const FrameImages& frame) const {
        return rig && sensor::fits(frame.left, rig->cam0) && sensor::fits(frame.right, rig->cam1);
    }
    void count(const cv::Mat& left) {
        for (const cv::Point& point : features::best_of_cells(
                 corners.of(left), kMinCornerScore, features::CornerScores::kBorder_px, kCell_px))
            points.emplace_back(point);
        image = left;
    }
};

DiveAssessment::DiveAssessment(const std::filesystem::path& dive_root)
    : implementation_(std::make_unique<Implementation>()) {
    implementation_->rig = read_rig(dive_root);
}

DiveAssessment::~DiveAssessment() = default;

void DiveAssessment::add(const FrameImages& before,
                         const FrameImages& now,
                         const ImageQuality& quality) {
    auto& own = *implementation_;
    own.quality = quality;
    own.points.clear();
    if (own.fits(before) && own.fits(now) && before.timestamp_ns < now.timestamp_ns)
        own.follow(before, now);
    else
        own.count(grey_of(now.left));
    ++own.num_frames;
}

nlohmann::json DiveAssessment::report() const {
    const auto& own = *implementation_;
    if (own.num_frames == 0) return nullptr;
    nlohmann::json report = {{"features", own.points.size()},
                             {"coverage", rounded(coverage(own.points, own.image.size()))},
                             {"mean_level", rounded(own.quality.mean_level)},
                             {"black", rounded(own.quality.black_share)},
                             {"bright", rounded(own.quality.bright_share)}};
    if (own.quality.sharpness) report["sharpness"] = rounded(*own.quality.sharpness);
    if (!own.odometry) return report;
    report["tracked"] = own.odometry->num_tracked();
    report["distance_m"] = rounded(own.odometry->distance_m());
    report["expected_drift_m"] = rounded(own.odometry->expected_drift_m());
    report["pairs"] = own.odometry->num_assessments();
    report["lost"] = own.odometry->num_lost();
    return report;
}

const LiveOdometry* DiveAssessment::odometry() const {
    return implementation_->odometry ? &*implementation_->odometry : nullptr;
}

cv::Mat DiveAssessment::image() const { return implementation_->image; }

const std::vector<TrackLine>& DiveAssessment::tracks() const {
    static const std::vector<TrackLine> kNone;
    return implementation_->odometry ? implementation_->odometry->tracks() : kNone;
}

}  // namespace divemesh::sensor
