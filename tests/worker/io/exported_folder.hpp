#pragma once

#include <Eigen/Geometry>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>
#include <vector>

#include "tests/worker/io/test_files.hpp"
#include "worker/io/ply.hpp"
#include "worker/io/reconstruction_folder.hpp"
#include "worker/types/keyframe.hpp"
#include "worker/types/rectified_rig.hpp"

namespace divemesh::io {

// A test with a small reconstruction: three keyframes whose images are half as large as those that
// were matched, a cloud of three points, the tetrahedron as mesh.
class ExportedFolderTest : public FileTest {
protected:
    ExportedFolderTest() {
        rig_.width_px = 640;
        rig_.height_px = 480;
        rig_.focal_px = 500.0;
        rig_.cx_px = 311.25;
        rig_.cy_px = 243.5;
        std::filesystem::create_directories(file("keyframes"));
        for (const int frame_index : {3, 12, 1'234'567}) {
            types::Keyframe keyframe;
            keyframe.frame_index = frame_index;
            keyframe.timestamp_ns = 1'600'000'000'000'000'000 + frame_index;
            keyframe.T_world_cam.linear() =
                Eigen::AngleAxisd(2.0 + 1e-7 * frame_index, Eigen::Vector3d(2, -1, 2) / 3.0)
                    .toRotationMatrix();
            keyframe.T_world_cam.translation() = Eigen::Vector3d(0.1, -0.2, 1.5);
            keyframes_.push_back(keyframe);
            write_image(frame_index, 320, 240);
        }
        write_keyframes();
        write_cloud({{0.1F, 0.2F, -0.3F}, {0.4F, -0.5F, 0.6F}, {-0.7F, 0.8F, 0.9F}});
        write_ply(file("mesh.ply"), tetrahedron());
        write("metrics.json", metrics().dump());
    }

    static nlohmann::json metrics() {
        return {{"version", "0.1.0"},
                {"preset", "standard"},
                {"options", {{"voxel_m", 0.01}, {"num_threads", 7}}},
                {"dive",
                 {{"name", "reef"}, {"content_sha256", "0123456789abcdef"}, {"duration_s", 60.5}}},
                {"calibration", {{"sha256", "fedc"}, {"scale_sigma", 0.00293}}},
                {"expected_accuracy", {{"level", 0.95}, {"surface", {{"sigma_median_m", 0.011}}}}},
                {"pieces",
                 {{{"intervals",
                    {{{"first_ns", 1'403'636'584'763'555'584},
                      {"last_ns", 1'403'636'592'000'000'000}}}}}}},
                {"speed", {{"wall_s", 12.3}}},
                {"verdict", "usable_with_restrictions"},
                {"restrictions", {"path", "scale"}},
                {"findings",
                 {{{"severity", "warning"}, {"code", "no_imu"}, {"message", "m"}},
                  {{"severity", "warning"}, {"code", "no_imu"}, {"message", "n"}}}}};
    }

    static std::string name_of(int frame_index) {
        char name[40];
        std::snprintf(name, sizeof name, "%06d.jpg", frame_index);
        return name;
    }
    void write_image(int frame_index, int width, int height) const {
        cv::imwrite(file("keyframes/" + name_of(frame_index)).string(),
                    cv::Mat(height, width, CV_8UC3, cv::Scalar(40, 80, 120)));
    }
    void write_keyframes() const {
        nlohmann::json list = nlohmann::json::array();
        for (const types::Keyframe& keyframe : keyframes_) {
            const Eigen::Vector3d p = keyframe.T_world_cam.translation();
            const Eigen::Quaterniond q(keyframe.T_world_cam.linear());
            list.push_back({{"frame_index", keyframe.frame_index},
                            {"timestamp_ns", keyframe.timestamp_ns},
                            {"position_m", {p.x(), p.y(), p.z()}},
                            {"orientation_wxyz", {q.w(), q.x(), q.y(), q.z()}}});
        }
        write("keyframes.json",
              nlohmann::json{{"image_size_px", {rig_.width_px, rig_.height_px}},
                             {"focal_px", rig_.focal_px},
                             {"principal_point_px", {rig_.cx_px, rig_.cy_px}},
                             {"keyframes", list}}
                  .dump());
    }
    void write_cloud(const std::vector<Eigen::Vector3f>& points) const {
        CloudPlyWriter cloud(file("cloud.ply"), std::ssize(points));
        for (const Eigen::Vector3f& point : points) cloud.add(point, {10, 20, 30});
        cloud.commit();
    }
    ReconstructionFolder open() const { return ReconstructionFolder(file("")); }

    // Returns where a point is in the small image of a keyframe, by our own camera: pixels of half
    // the size, counted from the corner of the image.
    Eigen::Vector2d small_pixel(std::size_t keyframe, const Eigen::Vector3d& p_world) const {
        const Eigen::Vector2d whole =
            rig_.pixel(keyframes_[keyframe].T_world_cam.inverse() * p_world);
        return 0.5 * (whole + Eigen::Vector2d::Constant(0.5));
    }

    // A point in front of all three keyframes.
    Eigen::Vector3d point_in_sight() const {
        return keyframes_[1].T_world_cam * Eigen::Vector3d(0.2, -0.1, 1.4);
    }

    types::RectifiedRig rig_;
    std::vector<types::Keyframe> keyframes_;
};

}  // namespace divemesh::io
