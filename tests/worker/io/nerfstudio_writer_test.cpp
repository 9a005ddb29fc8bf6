#include "worker/io/nerfstudio_writer.hpp"

#include <opencv2/imgcodecs.hpp>

#include "tests/worker/io/exported_folder.hpp"
#include "worker/io/exports.hpp"

namespace divemesh::io {
namespace {

using nlohmann::json;

class NerfstudioWriterTest : public ExportedFolderTest {
protected:
    json export_it() const {
        export_reconstruction(open(), {ExportFormat::Nerfstudio}, std::nullopt, file(""));
        return json::parse(read(file("nerfstudio/transforms.json")));
    }
};

// By nerfstudio's conventions: x right, y up, z back; pixels from the corner of the image.
TEST_F(NerfstudioWriterTest, ItsCameraSeesAPointWhereOursDoes) {
    const json transforms = export_it();

    ASSERT_EQ(transforms["frames"].size(), 3U);
    for (std::size_t i = 0; i < 3; ++i) {
        Eigen::Matrix4d T_world_gl;
        for (int row = 0; row < 4; ++row)
            for (int column = 0; column < 4; ++column)
                T_world_gl(row, column) =
                    transforms["frames"][i]["transform_matrix"][row][column].get<double>();
        const Eigen::Vector4d p = T_world_gl.inverse() * point_in_sight().homogeneous();
        const double depth_m = -p.z();
        const Eigen::Vector2d pixel(
            transforms["fl_x"].get<double>() * p.x() / depth_m + transforms["cx"].get<double>(),
            -transforms["fl_y"].get<double>() * p.y() / depth_m + transforms["cy"].get<double>());
        EXPECT_NEAR(depth_m, 1.4, 0.2);
        EXPECT_LT((pixel - small_pixel(i, point_in_sight())).norm(), 1e-9);
        const Eigen::Matrix3d R = T_world_gl.block(0, 0, 3, 3);
        EXPECT_NEAR(R.determinant(), 1.0, 1e-9);
    }
    EXPECT_EQ(transforms["w"], 320);
    EXPECT_EQ(transforms["h"], 240);
}

TEST_F(NerfstudioWriterTest, WholeImagesComeWithTheCameraOfTheirSize) {
    std::filesystem::remove_all(file("keyframes"));
    export_reconstruction(
        open(), {ExportFormat::Nerfstudio}, std::nullopt, file(""), [](int frame_index) {
            const double blue = frame_index == 12 ? 200.0 : 50.0;
            return cv::Mat(480, 640, CV_8UC3, cv::Scalar(blue, 100, 150));
        });
    const json transforms = json::parse(read(file("nerfstudio/transforms.json")));
    EXPECT_EQ(transforms["w"], 640);
    EXPECT_EQ(transforms["h"], 480);
    EXPECT_NEAR(transforms["fl_x"].get<double>(), rig_.focal_px, 1e-9);
    EXPECT_NEAR(transforms["cx"].get<double>(), rig_.cx_px + 0.5, 1e-9);
    EXPECT_NEAR(transforms["cy"].get<double>(), rig_.cy_px + 0.5, 1e-9);
    const cv::Mat second = cv::imread(file("nerfstudio/images/000012.jpg").string());
    ASSERT_EQ(second.size(), cv::Size(640, 480));
    EXPECT_NEAR(second.at<cv::Vec3b>(240, 320)[0], 200, 2);
}

TEST_F(NerfstudioWriterTest, NamesTheFilesBesideIt) {
    const json transforms = export_it();

    EXPECT_EQ(transforms["camera_model"], "OPENCV");
    for (const json& frame : transforms["frames"])
        EXPECT_TRUE(
            std::filesystem::exists(file("nerfstudio") / frame["file_path"].get<std::string>()));
    const auto points = file("nerfstudio") / transforms["ply_file_path"].get<std::string>();
    const types::Mesh cloud = read_ply(points);
    EXPECT_EQ(cloud.vertices, read_ply(file("cloud.ply")).vertices);
    EXPECT_EQ(cloud.colors, read_ply(file("cloud.ply")).colors);
    EXPECT_NE(read(points).find("\ncomment divemesh 0.1.0; verdict: "), std::string::npos);
    EXPECT_TRUE(std::filesystem::exists(file("nerfstudio/certificate.json")));
}

}  // namespace
}  // namespace divemesh::io
