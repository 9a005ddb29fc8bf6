#include "worker/dive/calibration.hpp"

#include <Eigen/SVD>
#include <algorithm>
#include <cmath>

#include "worker/base/angle.hpp"
#include "worker/base/rotation_vector.hpp"
#include "worker/base/text.hpp"
#include "worker/camera/projection.hpp"
#include "worker/dive/entry_name.hpp"
#include "worker/dive/lens_yaml.hpp"

namespace divemesh::dive {
namespace {

constexpr double kMaxRigSize_m = 5.0;

bool is_whole_in(double value, double low, double high) {
    return value >= low && value <= high && value == std::floor(value);
}

// Returns whether focal lengths are alike and the principal point is near the middle only if the
// second and the third number of fu, fv, cu, cv change places, as in a flattened camera matrix.
bool are_exchanged(const double* k, double width, double height) {
    const auto is_usual = [&](double fu, double fv, double cu, double cv) {
        return std::abs(fu / fv - 1.0) < 0.05 && std::abs(cu / width - 0.5) < 0.1 &&
               std::abs(cv / height - 0.5) < 0.1;
    };
    return !is_usual(k[0], k[1], k[2], k[3]) && is_usual(k[0], k[2], k[1], k[3]);
}

// Reads and checks the camera's parameters; each kind of error is reported once.
class CameraReader {
public:
    CameraReader(const SensorYaml& yaml, const std::string& file, FindingLog& findings)
        : yaml_(yaml), file_(file), findings_(findings) {}

    std::optional<types::Camera> read() {
        read_model();
        read_resolution();
        read_intrinsics();
        read_distortion();
        if (!good_) return std::nullopt;
        check_distortion();
        read_port();
        return good_ ? std::optional(camera_) : std::nullopt;
    }

private:
    void fail(const std::string& code, const std::string& what, const std::string& remedy) {
        findings_.error(code, file_, what, remedy);
        good_ = false;
    }

    void read_model() {
        if (camera_model_of(yaml_)) return;
        fail("calibration_model",
             "camera_model is '" + printable(yaml_.camera_model) +
                 "'; pinhole, omni, ds and eucm are read",
             "Calibrate again with one of them, for example the pinhole model with "
             "radial-tangential distortion, or equidistant for a fisheye (Kalibr: --models "
             "pinhole-radtan or pinhole-equi).");
    }

    void read_resolution() {
        const auto& size = yaml_.resolution;
        if (size.size() != 2 || !is_whole_in(size[0], 16, 65535) ||
            !is_whole_in(size[1], 16, 65535))
            return fail("calibration_resolution",
                        "resolution is missing or is not two whole numbers from 16 to 65535",
                        "Write resolution: [width, height] in pixels.");
        camera_.width_px = static_cast<int>(size[0]);
        camera_.height_px = static_cast<int>(size[1]);
    }

    void read_intrinsics() {
        const camera::LensModel* const model = camera_model_of(yaml_);
        if (!model) return;  // its numbers mean something else
        const std::size_t num_leading = model->leading.size();
        const std::size_t num_intrinsics = num_leading + 4;
        const auto& all = yaml_.intrinsics;
        if (all.size() != num_intrinsics)
            return fail("calibration_intrinsics",
                        "intrinsics has " + std::to_string(all.size()) + " numbers instead of " +
                            std::to_string(num_intrinsics),
                        "Write intrinsics: [" + intrinsics_names(*model) + "] in pixels.");
        types::LensCoefficients leading = {};
        for (std::size_t i = 0; i < num_leading; ++i) {
            leading[i] = all[i];
            if (!check_leading(model->leading[i], all[i])) return;
        }
        check_pinhole(&all[num_leading], model->focal_factor(leading));
    }

    bool check_leading(const camera::LeadingCoefficient& coefficient, double value) {
        if (value >= coefficient.min && value <= coefficient.max) return true;
        const std::string name(coefficient.name);
        fail("calibration_intrinsics",
             name + " is " + base::significant(value) + "; it is from " +
                 base::significant(coefficient.min) + " to " + base::significant(coefficient.max) +
                 " in this model",
             "Write intrinsics in Kalibr's order, " + name + " before the focal lengths.");
        return false;
    }

    // Checks fu fv cu cv; `factor` of LensModel::focal_factor.
    void check_pinhole(const double* k, double factor) {
        if (k[0] == 0.0 || k[1] == 0.0)
            return fail("calibration_not_invertible",
                        "a focal length is 0, so the camera matrix cannot be inverted",
                        "Calibrate the camera again.");
        const double width = camera_.width_px;
        const double height = camera_.height_px;
        if (are_exchanged(k, width, height))
            return fail("calibration_intrinsics",
                        "intrinsics seem to be in the order fu, cu, fv, cv: read so, both focal "
                        "lengths are alike and the principal point is near the middle",
                        "Write intrinsics: [fu, fv, cu, cv] in pixels.");
        const double focal_px = k[0] / factor;
        if (focal_px < 0.1 * width || focal_px > 20.0 * width || k[1] < 0.5 * k[0] ||
            k[1] > 2.0 * k[0])
            fail("calibration_intrinsics",
                 "focal lengths " + base::significant(k[0]) + " and " + base::significant(k[1]) +
                     " px are impossible for an image " + base::significant(width) + " px wide",
                 "Write focal lengths in pixels of the recorded resolution.");
        if (k[2] < 0.0 || k[3] < 0.0 || k[2] > width || k[3] > height)
            fail("calibration_intrinsics",
                 "the principal point (" + base::significant(k[2]) + ", " +
                     base::significant(k[3]) + ") px lies outside the image",
                 "Write the calibration for the recorded resolution.");
    }

    void read_distortion() {
        if (!camera_model_of(yaml_)) return;
        if (!is_distortion_known(yaml_))
            return fail("calibration_distortion",
                        "distortion_model '" + printable(yaml_.distortion_model) +
                            "' is not supported with camera_model " + yaml_.camera_model,
                        yaml_.camera_model == "pinhole"
                            ? "Use radial-tangential, equidistant or none."
                        : yaml_.camera_model == "omni" ? "Use radtan or none."
                                                       : "Use none.");
        const camera::LensModel* const model = lens_model_of(yaml_);
        if (!model) return fail_coefficients();
        if (good_) read_lens(yaml_, *model, camera_);
    }
    void fail_coefficients() {
        const auto& k = yaml_.distortion_coefficients;
        const bool is_radial = camera_model_of(yaml_)->camera_model == "pinhole" &&
                               yaml_.distortion_model.rfind("equi", 0) != 0 &&
                               yaml_.distortion_model != "fisheye";
        fail("calibration_distortion",
             "distortion_coefficients has " + std::to_string(k.size()) + " numbers, but " +
                 yaml_.distortion_model + " has " + (is_radial ? "4, 5 or 8" : "4"),
             "Calibrate again with four coefficients: k1 k2 p1 p2 of radial-tangential (or with k3 "
             "to k6 of OpenCV's rational model), or for wide lenses k1 k2 k3 k4 of equidistant. "
             "Just dropping coefficients is not enough, because the others depend on them.");
    }

    // Returns whether a pixel at the edge of a fisheye image belongs to a ray that is cut off.
    bool is_cut_off(const Eigen::Vector2d& pixel) const {
        if (!camera::is_fisheye(camera_)) return false;
        const Eigen::Vector2d centre(camera_.cx_px, camera_.cy_px);
        double reach_px = 0.0;
        constexpr int kSteps = 32;
        for (int i = 1; i <= kSteps; ++i) {
            const double angle = camera::kMaxFisheyeAngle_rad * i / kSteps;
            const auto seen =
                camera::project(camera_, Eigen::Vector3d(std::sin(angle), 0.0, std::cos(angle)));
            if (!seen || seen->x() - centre.x() <= reach_px) return false;  // the image folds
            reach_px = seen->x() - centre.x();
        }
        const double aspect = camera_.fx_px / camera_.fy_px;
        const Eigen::Vector2d offset = pixel - centre;
        return std::hypot(offset.x(), aspect * offset.y()) > reach_px;
    }

    // Checks that every pixel belongs to exactly one ray: projects and unprojects along rays to the
    // border of the image.
    void check_distortion() {
        const Eigen::Vector2d centre(camera_.cx_px, camera_.cy_px);
        const auto fails_at = [&](double share) {
            for (int i = 0; i < 16; ++i) {
                const double angle = i * 22.5 * base::kRadPerDeg;
                const Eigen::Vector2d border(
                    (0.5 + 0.5 * std::clamp(1.5 * std::cos(angle), -1.0, 1.0)) * camera_.width_px,
                    (0.5 + 0.5 * std::clamp(1.5 * std::sin(angle), -1.0, 1.0)) * camera_.height_px);
                const Eigen::Vector2d pixel = centre + share * (border - centre);
                if (is_cut_off(pixel)) continue;
                const auto back = camera::project(camera_, camera::unproject(camera_, pixel));
                if (!back || !((*back - pixel).norm() < 0.5)) return true;
            }
            return false;
        };
        if (fails_at(0.6))
            fail("calibration_not_invertible",
                 "the lens distortion folds the image over itself and cannot be inverted",
                 "Calibrate the camera again; check the order of the coefficients.");
        else if (fails_at(1.0))
            findings_.warning(
                "calibration_distortion",
                file_,
                "the lens distortion cannot be inverted at the border of the image",
                "Calibrate again with corners of the target near the border of the image.");
    }

    void read_port() {
        if (!yaml_.port) return;
        camera_.port = port_of(*yaml_.port, file_, findings_);
        good_ = good_ && camera_.port.has_value();
    }

    const SensorYaml& yaml_;
    const std::string& file_;
    FindingLog& findings_;
    types::Camera camera_;
    bool good_ = true;
};

// Returns whether the pair is stereo: x to the right, nearly along the baseline, and both cameras
// face the same way.
bool is_stereo(const Eigen::Isometry3d& T_cam0_cam1) {
    const Eigen::Vector3d baseline = T_cam0_cam1.translation();
    const double angle = base::angle_rad(T_cam0_cam1.linear());
    return baseline.x() > 0.7 * baseline.norm() && angle < 45.0 * base::kRadPerDeg;
}

std::string metres(const Eigen::Vector3d& v) {
    return "x " + base::fixed(v.x(), 3) + ", y " + base::fixed(v.y(), 3) + ", z " +
           base::fixed(v.z(), 3) + " m";
}

constexpr const char* kCam1Yaml = "mav0/cam1/sensor.yaml";

void check_sides(const CalibratedCamera& cam0, const CalibratedCamera& cam1, FindingLog& findings) {
    const Eigen::Isometry3d T_cam0_cam1 = cam0.T_body_cam.inverse() * cam1.T_body_cam;
    if (is_stereo(T_cam0_cam1)) return;
    const Eigen::Vector3d baseline = T_cam0_cam1.translation();
    if (baseline.x() < -0.7 * baseline.norm())
        return findings.error(
            "baseline_sign",
            kCam1Yaml,
            "cam1 is to the left of cam0, at " + metres(baseline) +
                " in cam0's frame: the cameras are swapped or T_BS is inverted",
            "If cam0 holds the right images too, rename the folders mav0/cam0 and mav0/cam1 to "
            "each "
            "other. If not, T_BS has to map the sensor's coordinates to the body's.");
    if (is_stereo(cam0.T_body_cam * cam1.T_body_cam.inverse()))
        return findings.error(
            "extrinsics_inverted",
            kCam1Yaml,
            "T_BS looks inverted: as written cam1 is at " + metres(baseline) +
                " in cam0's frame, which is not to its right; with the inverse it would be",
            "Write the inverse of what is there: T_BS maps the sensor's coordinates to the body's "
            "(Kalibr's T_cam_imu is the inverse of T_BS).");
    if (std::abs(baseline.y()) > 0.7 * baseline.norm())
        return findings.error(
            "cameras_not_stereo",
            kCam1Yaml,
            "cam1 is at " + metres(baseline) +
                " in cam0's frame, above or below it: a rig on its side",
            "Turn the images of both cameras by 90 degrees so that cam1 is to the right of cam0 "
            "(ffmpeg -vf transpose), and calibrate with the turned images.");
    const double angle_deg = base::angle_rad(T_cam0_cam1.linear()) * base::kDegPerRad;
    findings.error("cameras_not_stereo",
                   kCam1Yaml,
                   "cam1 is at " + metres(baseline) + " in cam0's frame, turned by " +
                       base::fixed(angle_deg, 1) + " degrees, which is not a left-right pair",
                   "Check T_BS of cam0 and cam1.");
}

}  // namespace

std::optional<Eigen::Isometry3d> rigid_motion(const SensorYaml& yaml,
                                              const std::string& file,
                                              FindingLog& findings) {
    if (!yaml.T_body_sensor) return Eigen::Isometry3d::Identity();
    const Eigen::Matrix4d& T = *yaml.T_body_sensor;
    const Eigen::Matrix3d R = T.topLeftCorner<3, 3>();
    const char* const remedy = "Write T_BS as a rotation and a translation in m, last row 0 0 0 1.";
    if (std::abs(R.determinant()) < 1e-6) {
        findings.error("calibration_not_invertible", file, "T_BS cannot be inverted", remedy);
        return std::nullopt;
    }
    const double skew = (R.transpose() * R - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff();
    const bool last_row_good =
        (T.row(3) - Eigen::RowVector4d(0, 0, 0, 1)).cwiseAbs().maxCoeff() < 1e-6;
    if (skew > 1e-3 || R.determinant() < 0.0 || !last_row_good) {
        findings.error("calibration_not_rigid",
                       file,
                       "T_BS is not a rotation and translation (R'R differs from 1 by " +
                           base::significant(skew, 2) + ", determinant " +
                           base::significant(R.determinant()) + ")",
                       remedy);
        return std::nullopt;
    }
    const Eigen::JacobiSVD<Eigen::Matrix3d> svd(R, Eigen::ComputeFullU | Eigen::ComputeFullV);
    Eigen::Isometry3d T_body_sensor = Eigen::Isometry3d::Identity();
    T_body_sensor.linear() = svd.matrixU() * svd.matrixV().transpose();
    T_body_sensor.translation() = T.topRightCorner<3, 1>();
    return T_body_sensor;
}

std::optional<CalibratedCamera> calibrated_camera(const SensorYaml& yaml,
                                                  const std::string& file,
                                                  FindingLog& findings) {
    const auto camera = CameraReader(yaml, file, findings).read();
    if (!yaml.T_body_sensor) {
        findings.error("calibration_missing",
                       file,
                       "T_BS is missing, so the position of the camera is not known",
                       "Write T_BS (sensor to body) of both cameras.");
        return std::nullopt;
    }
    const auto T_body_cam = rigid_motion(yaml, file, findings);
    if (!camera || !T_body_cam) return std::nullopt;
    return CalibratedCamera{*camera, *T_body_cam};
}

types::ImuNoise imu_noise(const SensorYaml& yaml, const std::string& file, FindingLog& findings) {
    types::ImuNoise noise;
    bool all_good = true;
    const auto take = [&](const std::optional<double>& value, double& target) {
        if (value && *value > 0.0 && *value < 100.0)
            target = *value;
        else
            all_good = false;
    };
    take(yaml.gyroscope_noise_density, noise.gyroscope_noise_density);
    take(yaml.gyroscope_random_walk, noise.gyroscope_random_walk);
    take(yaml.accelerometer_noise_density, noise.accelerometer_noise_density);
    take(yaml.accelerometer_random_walk, noise.accelerometer_random_walk);
    if (!all_good)
        findings.info("imu_noise_assumed",
                      file,
                      "the noise of the IMU is not fully stated; typical MEMS noise is assumed");
    return noise;
}

void check_stereo(const CalibratedCamera& cam0,
                  const CalibratedCamera& cam1,
                  FindingLog& findings) {
    const double baseline_m = (cam0.T_body_cam.inverse() * cam1.T_body_cam).translation().norm();
    if (baseline_m < 1e-4)
        return findings.error("baseline_zero",
                              kCam1Yaml,
                              "the baseline is 0: cam0 and cam1 are at the same place",
                              "Write T_BS of each camera, with translations in m.");
    if (baseline_m > kMaxRigSize_m)
        return findings.error(
            "baseline_absurd",
            kCam1Yaml,
            "the baseline is " + base::significant(baseline_m) + " m, which is too long",
            "Write translations in m, not mm or cm.");
    const double distance_m = cam0.T_body_cam.translation().norm();
    if (distance_m > kMaxRigSize_m)
        return findings.error("extrinsics_absurd",
                              "mav0/cam0/sensor.yaml",
                              "T_BS puts cam0 " + base::significant(distance_m) +
                                  " m from the body, which is too far",
                              "Write translations in m, not mm or cm.");
    if (baseline_m < 0.005)
        findings.warning("baseline_short",
                         kCam1Yaml,
                         "the baseline is only " + base::significant(baseline_m * 1e3) + " mm",
                         "Check that the translations in T_BS are in m.");
    check_sides(cam0, cam1, findings);
}

}  // namespace divemesh::dive
