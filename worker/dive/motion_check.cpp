#include "worker/dive/motion_check.hpp"

#include <algorithm>
#include <cmath>
#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>
#include <optional>

#include "worker/base/angle.hpp"
#include "worker/base/parallel.hpp"
#include "worker/base/rotation_vector.hpp"
#include "worker/base/seconds.hpp"
#include "worker/base/text.hpp"
#include "worker/camera/rectified_lens.hpp"
#include "worker/dive/mounting_check.hpp"
#include "worker/dive/stamp_check.hpp"
#include "worker/dive/stereo_rays.hpp"
#include "worker/dive/track_corners.hpp"
#include "worker/stats/median.hpp"

namespace divemesh::dive {
namespace {

constexpr int kNumMoments = 12;
constexpr std::size_t kMomentsAtOnce = 2;  // each holds three images and their pyramids
constexpr int kMaxWidth_px = 960;          // of the images that are compared
constexpr double kMaxEpipolarError_px = 3.0;
constexpr double kMaxReprojectionError_px = 2.0;
constexpr double kMaxSwappedError_px = 0.5;  // beyond that of the images as they are
constexpr double kMinFlippedError_px = 2.0;
constexpr double kMaxFlippedError_px = 0.4;
constexpr double kMaxInterval_s = 0.5;
constexpr double kMinRotation_rad = 3.0 * base::kRadPerDeg;
constexpr int kMinPoints = 25;
constexpr std::int64_t kGapPeriods = 5;  // a longer interval of the gyro is a gap

// Two frames a short time apart and the rotation between them from the gyro; twice the same frame
// where no rotation is known.
struct Moment {
    int first = 0;
    int second = 0;
    double duration_s = 0.0;
    Eigen::Vector3d rotation_imu = Eigen::Vector3d::Zero();  // rad

    bool is_motion() const { return second > first; }
};

// Returns the rotation vector of imu at `end_ns` in imu at `begin_ns`; nullopt over a gap of the
// IMU, where the rotation is not known.
std::optional<Eigen::Vector3d> integrate_gyro(const std::vector<types::ImuSample>& imu,
                                              std::int64_t begin_ns,
                                              std::int64_t end_ns,
                                              std::int64_t max_interval_ns) {
    auto sample = std::lower_bound(
        imu.begin(), imu.end(), begin_ns, [](const types::ImuSample& s, std::int64_t time) {
            return s.timestamp_ns < time;
        });
    Eigen::Quaterniond rotation = Eigen::Quaterniond::Identity();
    for (std::int64_t now = begin_ns; sample != imu.end() && now < end_ns; ++sample) {
        if (sample->timestamp_ns - now > max_interval_ns) return std::nullopt;
        const std::int64_t until = std::min(sample->timestamp_ns, end_ns);
        const double seconds = base::to_s(until - now);
        rotation = rotation * base::rotation_from_vector(sample->angular_velocity_imu * seconds);
        now = until;
    }
    return base::vector_from_rotation(rotation);
}

// Returns the moment from frame `first` until the rotation is large enough to be visible, or half a
// second has passed.
Moment moment_at(const DiveContents& contents, int first, std::int64_t max_interval_ns) {
    const auto time = [&](int i) {
        return contents.frames.pairs[static_cast<std::size_t>(i)].timestamp_ns;
    };
    const int num_pairs = static_cast<int>(contents.frames.pairs.size());
    Moment moment{first, first, 0.0, Eigen::Vector3d::Zero()};
    if (contents.imu.empty()) return moment;
    for (int second = first + 1; second < num_pairs; ++second) {
        const double seconds = base::to_s(time(second) - time(first));
        if (seconds > kMaxInterval_s) break;
        const auto rotation =
            integrate_gyro(contents.imu, time(first), time(second), max_interval_ns);
        if (!rotation) break;
        moment = {first, second, seconds, *rotation};
        if (rotation->norm() > kMinRotation_rad) break;
    }
    return moment;
}

// Returns the fastest rotation in each twelfth of the dive, or its first frame.
std::vector<Moment> choose_moments(const DiveContents& contents) {
    std::vector<Moment> moments;
    const std::int64_t max_interval_ns =
        kGapPeriods * median_period_ns(timestamps_of(contents.imu));
    const int num_pairs = static_cast<int>(contents.frames.pairs.size());
    for (int part = 0; part < kNumMoments; ++part) {
        const int begin = part * num_pairs / kNumMoments;
        const int end = (part + 1) * num_pairs / kNumMoments;
        const int step = std::max(1, (end - begin) / 20);
        Moment best{.first = begin, .second = begin};
        for (int i = begin; i < end; i += step) {
            const Moment moment = moment_at(contents, i, max_interval_ns);
            if (moment.rotation_imu.norm() > best.rotation_imu.norm()) best = moment;
        }
        if (begin < end) moments.push_back(best);
    }
    return moments;
}

// The point where the rays of both cameras are nearest to each other.
struct StereoPoint {
    Eigen::Vector3d p_cam0 = Eigen::Vector3d::Zero();
    double epipolar_error_px = 0.0;
    double inverse_depth = 0.0;  // negative: the rays meet behind the camera
};

StereoPoint triangulate(const StereoRays& rays, const cv::Point2f& left, const cv::Point2f& right) {
    const Eigen::Vector3d left_ray = rays.left(left);
    const Eigen::Vector3d right_ray = rays.right(right);
    StereoPoint point;
    point.inverse_depth = rays.inverse_depth_1_m(left_ray, right_ray);
    point.p_cam0 = left_ray / point.inverse_depth;
    point.epipolar_error_px = std::abs(rays.epipolar_error_px(left_ray, right_ray));
    return point;
}

// Returns where the pixel is if the image of this camera is mirrored from left to right.
cv::Point2f mirrored_px(const cv::Point2f& pixel, const types::Camera& camera) {
    return {static_cast<float>(camera.width_px - 1) - pixel.x, pixel.y};
}

// Returns where the pixel is if the image of this camera is mirrored from top to bottom.
cv::Point2f flipped_px(const cv::Point2f& pixel, const types::Camera& camera) {
    return {pixel.x, static_cast<float>(camera.height_px - 1) - pixel.y};
}

types::Rig swapped(const types::Rig& rig) {
    types::Rig result = rig;
    std::swap(result.cam0, result.cam1);
    std::swap(result.T_imu_cam0, result.T_imu_cam1);
    return result;
}

// Returns by what whole number images of a width are reduced.
int reduction_of(int width_px) { return std::max(1, (width_px + kMaxWidth_px - 1) / kMaxWidth_px); }

// The points of images that are read in one way.
class StereoPoints {
public:
    void add(const StereoPoint& point) { points_.push_back(point); }
    void add(const StereoPoints& other) {
        points_.insert(points_.end(), other.points_.begin(), other.points_.end());
    }
    std::ptrdiff_t size() const { return std::ssize(points_); }
    std::ptrdiff_t num_behind() const {
        return std::ranges::count_if(
            points_, [](const StereoPoint& point) { return point.inverse_depth < -0.01; });
    }
    double median_error_px() const {
        std::vector<double> errors_px;
        errors_px.reserve(points_.size());
        for (const StereoPoint& point : points_) errors_px.push_back(point.epipolar_error_px);
        return stats::upper_median(std::move(errors_px));
    }

private:
    std::vector<StereoPoint> points_;
};

// What the images of a moment show.
struct Seen {
    MountingCheck mounting;
    StereoPoints stereo;
    StereoPoints swapped;   // with the images of the cameras swapped
    StereoPoints mirrored;  // with both images mirrored from left to right
    StereoPoints flipped;   // with both images mirrored from top to bottom
    std::optional<RotationPair> rotation;
};

class MotionCheck {
public:
    MotionCheck(const DiveContents& contents,
                const std::function<LoadedPair(int index, Eyes eyes)>& load,
                FindingLog& findings)
        : contents_(contents),
          load_(load),
          findings_(findings),
          reduction_(reduction_of(contents.rig.cam0.width_px)) {
        if (!contents.fixed_pattern.empty())
            is_scene_ = camera::reduced_image(contents.fixed_pattern, reduction_) == 0;
    }

    void run(const base::ProgressCallback& progress) {
        const std::vector<Moment> moments = choose_moments(contents_);
        for (std::size_t begin = 0; begin < moments.size(); begin += kMomentsAtOnce) {
            progress({});
            std::vector<Seen> seen(std::min(kMomentsAtOnce, moments.size() - begin));
            base::for_each_index(static_cast<int>(kMomentsAtOnce), seen.size(), [&](std::size_t i) {
                look_at(moments[begin + i], seen[i]);
            });
            for (const Seen& of_moment : seen) add(of_moment);
        }
        mounting_.report(findings_);
        report_stereo();
        report_hand_eye(rotations_, contents_.rig.T_imu_cam0.linear(), findings_);
    }

private:
    void look_at(const Moment& moment, Seen& seen) const {
        const LoadedPair first = load_(moment.first, Eyes::Both);
        if (!first.is_complete()) return;
        const cv::Mat left = camera::reduced_image(first.left.image, reduction_);
        const cv::Mat right = camera::reduced_image(first.right.image, reduction_);
        std::vector<cv::Point2f> corners;
        cv::goodFeaturesToTrack(left, corners, 250, 0.01, 12.0, is_scene_);
        if (std::ssize(corners) < kMinPoints) return;
        std::vector<bool> found(corners.size(), true);
        const auto in_right = track_corners(left, right, corners, found);
        seen.mounting.add(left, right, corners, in_right, found);
        const std::vector<bool> found_in_right = found;
        std::vector<cv::Point2f> later = corners;
        if (moment.is_motion()) {
            const LoadedPair second = load_(moment.second, Eyes::Left);
            if (second.left.image.empty()) return;
            later = track_corners(
                left, camera::reduced_image(second.left.image, reduction_), corners, found);
        }
        std::vector<cv::Point3d> points;
        std::vector<cv::Point2d> rays;
        for (std::size_t i = 0; i < corners.size(); ++i) {
            if (!found_in_right[i]) continue;
            const cv::Point2f corner = recorded_px(corners[i]);
            const cv::Point2f other = recorded_px(in_right[i]);
            const StereoPoint point = triangulate(rays_, corner, other);
            seen.stereo.add(point);
            seen.swapped.add(triangulate(swapped_rays_, corner, other));
            seen.mirrored.add(triangulate(rays_,
                                          mirrored_px(corner, contents_.rig.cam0),
                                          mirrored_px(other, contents_.rig.cam1)));
            seen.flipped.add(triangulate(rays_,
                                         flipped_px(corner, contents_.rig.cam0),
                                         flipped_px(other, contents_.rig.cam1)));
            if (!found[i] || point.epipolar_error_px > kMaxEpipolarError_px * reduction_ ||
                point.inverse_depth < 0.02)
                continue;
            const Eigen::Vector3d ray = rays_.left(recorded_px(later[i]));
            points.emplace_back(point.p_cam0.x(), point.p_cam0.y(), point.p_cam0.z());
            rays.emplace_back(ray.x(), ray.y());
        }
        if (moment.is_motion()) seen.rotation = rotation_of(moment, points, rays);
    }

    // Returns the pixel of the image as recorded.
    cv::Point2f recorded_px(const cv::Point2f& reduced_px) const {
        const float offset_px = 0.5F * static_cast<float>(reduction_ - 1);
        return reduced_px * static_cast<float>(reduction_) + cv::Point2f(offset_px, offset_px);
    }

    std::optional<RotationPair> rotation_of(const Moment& moment,
                                            const std::vector<cv::Point3d>& points,
                                            const std::vector<cv::Point2d>& rays) const {
        if (std::ssize(points) < kMinPoints) return std::nullopt;
        cv::Mat rotation;
        cv::Mat shift;
        std::vector<int> inliers;
        const double tolerance = kMaxReprojectionError_px * reduction_ / contents_.rig.cam0.fx_px;
        if (!cv::solvePnPRansac(points,
                                rays,
                                cv::Mat::eye(3, 3, CV_64F),
                                cv::noArray(),
                                rotation,
                                shift,
                                false,
                                200,
                                static_cast<float>(tolerance),
                                0.99,
                                inliers))
            return std::nullopt;
        if (std::ssize(inliers) * 2 < std::ssize(points)) return std::nullopt;
        // PnP maps the first camera's coordinates to the second's; the rotation of the rig is its
        // inverse.
        const Eigen::Vector3d rotation_cam0(
            -rotation.at<double>(0), -rotation.at<double>(1), -rotation.at<double>(2));
        return RotationPair{moment.rotation_imu / moment.duration_s,
                            rotation_cam0 / moment.duration_s};
    }

    void add(const Seen& seen) {
        mounting_.add(seen.mounting);
        stereo_.add(seen.stereo);
        swapped_.add(seen.swapped);
        mirrored_.add(seen.mirrored);
        flipped_.add(seen.flipped);
        if (seen.rotation) rotations_.push_back(*seen.rotation);
    }

    // Returns whether points lie in front of the cameras, no farther off their rows, if the images
    // are read in this way.
    bool fits_as(const StereoPoints& read) const {
        return read.num_behind() * 5 < stereo_.size() &&
               read.median_error_px() <
                   stereo_.median_error_px() + kMaxSwappedError_px * reduction_;
    }

    void report_stereo() {
        if (stereo_.size() < std::ptrdiff_t{4} * kMinPoints) return;
        const std::ptrdiff_t num_behind = stereo_.num_behind();
        if (num_behind * 2 <= stereo_.size()) return report_flipped();
        const std::string seen = std::to_string(num_behind) + " of " +
                                 std::to_string(stereo_.size()) +
                                 " points would lie behind the cameras, ";
        if (fits_as(swapped_))
            return findings_.error(
                "cameras_swapped",
                "mav0/cam0/data",
                seen + "so the left and right images seem to be swapped",
                "Swap the folders: cam0 is the left camera, cam1 the right one. If the recorder "
                "turned both images by 180 degrees because the rig was upside down, turn them back "
                "instead.");
        if (fits_as(mirrored_))
            findings_.error("camera_turned",
                            "mav0/cam0/data",
                            seen + "but not if both images are mirrored from left to right",
                            "Mirror the images of both cameras back (ffmpeg -vf hflip), or "
                            "calibrate with mirrored images.");
    }

    // Images that are both mirrored from top to bottom give depths, but rows that fit only the
    // mirrored calibration. A rig whose cameras moved may do so by chance, so this is a warning.
    void report_flipped() {
        const double error_px = stereo_.median_error_px();
        const double flipped_error_px = flipped_.median_error_px();
        if (error_px < kMinFlippedError_px * reduction_ ||
            flipped_error_px > kMaxFlippedError_px * reduction_)
            return;
        findings_.warning("camera_turned",
                          "mav0/cam0/data",
                          "matching points in the left and right images lie " +
                              base::fixed(error_px, 1) + " px off their rows, and " +
                              base::fixed(flipped_error_px, 1) +
                              " px if both images are mirrored from top to bottom",
                          "If the images are upside down, flip those of both cameras (ffmpeg -vf "
                          "vflip): a model of flipped images is a mirror image of the scene.");
    }

    const DiveContents& contents_;
    const std::function<LoadedPair(int index, Eyes eyes)>& load_;
    FindingLog& findings_;
    const int reduction_;  // of the images; all tolerances grow with it
    cv::Mat is_scene_;     // 255 outside the fixed pattern; empty: all of the image
    const StereoRays rays_{contents_.rig};
    const StereoRays swapped_rays_{swapped(contents_.rig)};
    MountingCheck mounting_;
    StereoPoints stereo_;
    StereoPoints swapped_;
    StereoPoints mirrored_;
    StereoPoints flipped_;
    std::vector<RotationPair> rotations_;
};

}  // namespace

void check_motion(const DiveContents& contents,
                  const std::function<LoadedPair(int index, Eyes eyes)>& load,
                  const base::ProgressCallback& progress,
                  FindingLog& findings) {
    MotionCheck(contents, load, findings).run(progress);
}

}  // namespace divemesh::dive
