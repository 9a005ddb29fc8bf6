#include "worker/io/exports.hpp"

#include <array>
#include <cmath>
#include <map>
#include <numbers>
#include <opencv2/imgcodecs.hpp>
#include <sstream>

#include "tests/worker/io/exported_folder.hpp"
#include "tests/worker/io/unzipped.hpp"
#include "worker/io/geographic_frame.hpp"
#include "worker/io/mosaic_files.hpp"
#include "worker/io/obj_writer.hpp"
#include "worker/io/raster_reader.hpp"
#include "worker/io/trajectory_file.hpp"

namespace divemesh::io {
namespace {

class ExportsTest : public FileTest {};

types::Trajectory two_poses() {
    types::Trajectory trajectory(2);
    trajectory[0].timestamp_ns = 1'600'000'000'000'000'001;
    trajectory[1].timestamp_ns = 1'600'000'000'100'000'002;
    trajectory[1].T_world_imu.translation() = Eigen::Vector3d(1.5, -2.0, 0.25);
    trajectory[1].T_world_imu.linear() =
        Eigen::AngleAxisd(0.3, Eigen::Vector3d(1, 2, -2) / 3.0).toRotationMatrix();
    return trajectory;
}

void expect_same_pose(const Eigen::Isometry3d& pose, const Eigen::Isometry3d& truth) {
    EXPECT_LT((pose.matrix() - truth.matrix()).cwiseAbs().maxCoeff(), 2e-9);
}

TEST_F(ExportsTest, AnEurocFileReadsBackWithItsStamps) {
    write_euroc(file("poses.csv"), two_poses());

    const TrajectoryFile read = read_trajectory(file("poses.csv"));

    EXPECT_EQ(read.format, TrajectoryFormat::Euroc);
    ASSERT_EQ(read.poses.size(), 2U);
    EXPECT_EQ(read.poses[1].timestamp_ns, 1'600'000'000'100'000'002);
    expect_same_pose(read.poses[1].T_world_imu, two_poses()[1].T_world_imu);
}

TEST_F(ExportsTest, AKittiFileHoldsTheUpperThreeRowsOfThePose) {
    write_kitti(file("poses.txt"), two_poses());

    EXPECT_TRUE(FileTest::read(file("poses.txt"))
                    .starts_with("1.000000000 0.000000000 0.000000000 0.000000000 0.000000000 "
                                 "1.000000000 0.000000000 0.000000000 0.000000000 0.000000000 "
                                 "1.000000000 0.000000000\n"));
    const TrajectoryFile read = read_trajectory(file("poses.txt"));
    EXPECT_EQ(read.format, TrajectoryFormat::Kitti);
    expect_same_pose(read.poses[1].T_world_imu, two_poses()[1].T_world_imu);
}

// The CN Tower as in Wikipedia's article on UTM: 17N 630084 4833438.
TEST(GeographicFrameTest, PutsAKnownPlaceWhereItIsKnownToBe) {
    const UtmFrame frame =
        utm_frame({43.0 + 38.0 / 60 + 33.24 / 3600, -(79.0 + 23.0 / 60 + 13.7 / 3600), 90.0});

    EXPECT_EQ(frame.epsg, 32617);
    EXPECT_NEAR(frame.A(0, 2), 630084.0, 1.0);
    EXPECT_NEAR(frame.A(1, 2), 4833438.0, 1.0);
}

TEST(GeographicFrameTest, OnTheCentralMeridianTheGridIsNorthAndTheScaleIs0_9996) {
    const UtmFrame frame = utm_frame({-33.0, 153.0, 90.0});

    EXPECT_EQ(frame.epsg, 32756);
    EXPECT_NEAR(frame.A(0, 2), 500'000.0, 1e-6);
    Eigen::Matrix2d scaled = 0.9996 * Eigen::Matrix2d::Identity();
    EXPECT_LT((frame.A.leftCols<2>() - scaled).cwiseAbs().maxCoeff(), 1e-9);
}

// One second of latitude, whose length on the ellipsoid follows from the meridian's radius of
// curvature. The place is away from the central meridian, where the grid is rotated by 2 degrees.
TEST(GeographicFrameTest, AStepToTheNorthIsThatOfTheGrid) {
    constexpr double kStep_deg = 1.0 / 3600;
    constexpr double kLatitude_deg = 45.0;
    const double e2 = (2.0 - 1.0 / 298.257223563) / 298.257223563;
    const double middle = (kLatitude_deg + kStep_deg / 2) * std::numbers::pi / 180.0;
    const double radius_m =
        6378137.0 * (1.0 - e2) / std::pow(1.0 - e2 * std::pow(std::sin(middle), 2), 1.5);
    const double step_m = radius_m * kStep_deg * std::numbers::pi / 180.0;
    const UtmFrame here = utm_frame({kLatitude_deg, 12.0 + 5.9, 30.0});
    const UtmFrame north = utm_frame({kLatitude_deg + kStep_deg, 12.0 + 5.9, 30.0});

    // x points to azimuth 30 degrees and y to -60: north is cos(30) of x and sin(30) of y.
    const Eigen::Vector3d p_world(
        step_m * std::cos(std::numbers::pi / 6), step_m * std::sin(std::numbers::pi / 6), 1.0);

    EXPECT_LT((here.A * p_world - north.A.col(2)).norm(), 1e-3);
}

TEST(GeographicFrameTest, APlaceThatUtmDoesNotCoverIsRefused) {
    EXPECT_EQ(error_of([] { utm_frame({89.0, 0.0, 0.0}); }).code(), ErrorCode::InvalidArgument);
    EXPECT_EQ(error_of([] {
                  utm_frame({0.0, std::nan(""), 0.0});
              }).code(),
              ErrorCode::InvalidArgument);
}

TEST_F(ExportsTest, AnObjZipHoldsMeshAndMaterial) {
    write_obj_zip(file("mesh.zip"), tetrahedron(), nullptr);

    auto files = unzipped(file("mesh.zip"));

    ASSERT_EQ(files.size(), 2U);
    const std::string& obj = files["mesh.obj"];
    EXPECT_NE(obj.find("mtllib mesh.mtl\n"), std::string::npos);
    EXPECT_NE(obj.find("usemtl surface\n"), std::string::npos);
    EXPECT_NE(obj.find("v 1 0 0 1 0 0\n"), std::string::npos);
    EXPECT_NE(obj.find("vn 0 0 1\n"), std::string::npos);
    EXPECT_NE(obj.find("f 1//1 3//3 2//2\n"), std::string::npos);
    EXPECT_NE(files["mesh.mtl"].find("newmtl surface\n"), std::string::npos);
}

TEST_F(ExportsTest, ARemarkIsACommentOfTheObj) {
    write_obj_zip(file("mesh.zip"), tetrahedron(), nullptr, "verdict: good");

    EXPECT_TRUE(unzipped(file("mesh.zip"))["mesh.obj"].starts_with("# m, z up\n# verdict: good\n"));
}

TEST_F(ExportsTest, AnObjZipHoldsAtlasesAndTextureCoordinatesWithVUp) {
    StoredTexture texture;
    texture.jpegs = {"the first", "the second"};
    texture.atlas_of_triangle = {
        0, types::TextureMap::kUntextured, 0, types::TextureMap::kUntextured};
    texture.uv.resize(4);
    texture.uv[0] = {Eigen::Vector2f(0, 0), Eigen::Vector2f(1, 0.25F), Eigen::Vector2f(0, 0.5F)};
    texture.uv[2] = {Eigen::Vector2f(0, 0), Eigen::Vector2f(0.5F, 1), Eigen::Vector2f(1, 0.25F)};
    write_obj_zip(file("mesh.zip"), tetrahedron(), &texture);

    auto files = unzipped(file("mesh.zip"));

    ASSERT_EQ(files.size(), 3U);
    const std::string& obj = files["mesh.obj"];
    EXPECT_NE(
        obj.find("usemtl atlas_0\nvt 0 1\nvt 1 0.75\nvt 0 0.5\nvt 0.5 0\n"
                 "f 1/1/1 3/2/3 2/3/2\nf 1/1/1 4/4/4 3/2/3\nusemtl surface\nf 1//1 2//2 4//4\n"),
        std::string::npos);
    EXPECT_NE(
        files["mesh.mtl"].find("newmtl atlas_0\nKa 1 1 1\nKd 1 1 1\nillum 0\nmap_Kd atlas_0.jpg\n"),
        std::string::npos);
    EXPECT_EQ(files["atlas_0.jpg"], "the first");
}

TEST_F(ExportsTest, TheSameMeshGivesTheSameZip) {
    write_obj_zip(file("one.zip"), tetrahedron(), nullptr);
    write_obj_zip(file("two.zip"), tetrahedron(), nullptr);

    EXPECT_EQ(FileTest::read(file("one.zip")), FileTest::read(file("two.zip")));
}

TEST_F(ExportsTest, AGeoTiffWithoutAPositionSaysWhereToWriteOne) {
    write("metrics.json", "{}");

    const Error error = error_of([&] {
        export_reconstruction(
            ReconstructionFolder(file("")), {ExportFormat::Geotiff}, std::nullopt, file("out"));
    });

    EXPECT_EQ(error.code(), ErrorCode::InvalidArgument);
    EXPECT_NE(std::string(error.what()).find("dive.json"), std::string::npos);
}

TEST_F(ExportsTest, AGeoTiffOfAResultWithoutAMosaicSaysHowToMakeOne) {
    write("metrics.json", "{}");

    const Error error = error_of([&] {
        export_reconstruction(ReconstructionFolder(file("")),
                              {ExportFormat::Geotiff},
                              types::GeographicPosition{45.0, 15.0, 90.0},
                              file("out"));
    });

    EXPECT_EQ(error.code(), ErrorCode::NotFound);
    EXPECT_NE(std::string(error.what()).find("--no-texture"), std::string::npos);
}

TEST_F(ExportsTest, GeoTiffsKeepTheirPixelsAndGetAPlace) {
    write("metrics.json", "{}");
    const types::RasterGrid grid{400, 300, 0.003, 1.0, 2.0};
    cv::Mat color(300, 400, CV_8UC4, cv::Scalar(1, 2, 3, 255));
    cv::randu(color.rowRange(100, 200), 0, 255);
    const cv::Mat heights(300, 400, CV_32F, cv::Scalar::all(-1.5));
    MosaicWriter writer(file(""), grid, std::nullopt, 1);
    writer.append(color, heights, heights);
    writer.commit();
    const types::GeographicPosition position{45.0, 15.0, 90.0};  // x to the east, y to the north

    const auto names = export_reconstruction(
        ReconstructionFolder(file("")), {ExportFormat::Geotiff}, position, file("out"));

    EXPECT_EQ(names,
              (std::vector<std::string>{"mosaic.tif",
                                        "heights.tif",
                                        "heights_sigma.tif",
                                        "mosaic.tfw",
                                        "heights.tfw",
                                        "certificate.json"}));
    for (const char* name : {"mosaic.tif", "heights.tif"}) {
        RasterReader stored(file(name));
        RasterReader placed(file(std::string("out/") + name));
        ASSERT_EQ(placed.size(), cv::Size(grid.width_px, grid.height_px));
        const cv::Mat truth = stored.rows(0, grid.height_px);
        const cv::Mat copy = placed.rows(0, grid.height_px);
        EXPECT_TRUE(std::equal(truth.datastart, truth.dataend, copy.datastart)) << name;
    }
    // On the central meridian of zone 33 the origin lies at 500 km east, and lengths are 0.9996.
    std::istringstream place(FileTest::read(file("out/mosaic.tfw")));
    std::array<double, 6> values{};
    for (double& value : values) place >> value;
    EXPECT_NEAR(values[0], 0.9996 * 0.003, 1e-12);
    EXPECT_NEAR(values[3], -0.9996 * 0.003, 1e-12);
    EXPECT_NEAR(values[4], 500'000.0 + 0.9996 * (grid.corner_x_m + 0.0015), 1e-5);
}

class ExportsOfAFolderTest : public ExportedFolderTest {
protected:
    Error refusal(ExportFormat format) const {
        return error_of(
            [&] { export_reconstruction(open(), {format}, std::nullopt, file("out")); });
    }
};

TEST_F(ExportsOfAFolderTest, AMissingSurfaceIsNamed) {
    for (const char* name : {"cloud.ply", "mesh.ply"}) std::filesystem::remove(file(name));
    const std::vector<std::pair<ExportFormat, std::string>> needed = {
        {ExportFormat::Obj, "mesh.ply"},
        {ExportFormat::Ply, "mesh.ply"},
        {ExportFormat::Las, "mesh.ply"},
        {ExportFormat::Laz, "mesh.ply"},
        {ExportFormat::Tiles, "mesh.ply"},
        {ExportFormat::Mcap, "cloud.ply"},
        {ExportFormat::E57, "cloud.ply"},
        {ExportFormat::Colmap, "cloud.ply"},
        {ExportFormat::Nerfstudio, "cloud.ply"}};
    for (const auto& [format, name] : needed) {
        EXPECT_EQ(refusal(format).code(), ErrorCode::NotFound) << name;
        EXPECT_NE(std::string(refusal(format).what()).find(name), std::string::npos);
    }
}

TEST_F(ExportsOfAFolderTest, ABrokenSurfaceIsBadData) {
    for (const char* name : {"cloud.ply", "mesh.ply"})
        write(name,
              "ply\nformat ascii 1.0\nelement vertex 99999999999\nproperty float x\nend_header\n");
    for (const auto format : {ExportFormat::Las,
                              ExportFormat::Laz,
                              ExportFormat::E57,
                              ExportFormat::Colmap,
                              ExportFormat::Nerfstudio})
        EXPECT_EQ(refusal(format).code(), ErrorCode::BadData);
}

TEST_F(ExportsOfAFolderTest, BrokenKeyframesAreBadData) {
    write("keyframes.json", R"({"keyframes": [{"frame_index": "seven"}]})");

    for (const auto format : {ExportFormat::Colmap, ExportFormat::Nerfstudio})
        EXPECT_EQ(refusal(format).code(), ErrorCode::BadData);
}

TEST_F(ExportsOfAFolderTest, PointsWithoutAColourAreGrey) {
    write("cloud.ply",
          "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\n"
          "property float z\nend_header\n1 2 3\n");

    export_reconstruction(open(), {ExportFormat::Nerfstudio}, std::nullopt, file("out"));

    EXPECT_EQ(read_ply(file("out/nerfstudio/points.ply")).colors[0], (types::Color{128, 128, 128}));
}

TEST_F(ExportsOfAFolderTest, TilesOfAnEarlierExportAreRemoved) {
    std::filesystem::create_directories(file("out/tiles"));
    write("out/tiles/0123.glb", "of a larger mesh");
    write("out/tiles/notes.txt", "mine");

    export_reconstruction(open(), {ExportFormat::Tiles}, std::nullopt, file("out"));

    EXPECT_FALSE(std::filesystem::exists(file("out/tiles/0123.glb")));
    EXPECT_TRUE(std::filesystem::exists(file("out/tiles/tileset.json")));
    EXPECT_TRUE(std::filesystem::exists(file("out/tiles/notes.txt")));
}

TEST_F(ExportsOfAFolderTest, TheNextReconstructionRemovesThem) {
    write_tum(file("trajectory.tum"), two_poses());
    export_reconstruction(open(),
                          {ExportFormat::Colmap,
                           ExportFormat::Nerfstudio,
                           ExportFormat::Ply,
                           ExportFormat::Las,
                           ExportFormat::Laz,
                           ExportFormat::E57,
                           ExportFormat::Tiles,
                           ExportFormat::Mcap},
                          std::nullopt,
                          file(""));
    for (const char* name :
         {"tiles/root.glb", "tiles/certificate.json", "reconstruction.mcap", "surface.laz"})
        EXPECT_TRUE(std::filesystem::exists(file(name))) << name;

    remove_reconstruction(file(""));

    EXPECT_TRUE(std::filesystem::is_empty(file("")));
}

TEST(ExportFormatTest, AnUnknownFormatIsToldWithThoseThatAreThere) {
    EXPECT_EQ(export_formats("kitti,obj,ply,colmap,nerfstudio,las,laz,e57,3dtiles,mcap").size(),
              10U);
    const Error error = error_of([] { export_formats("kitti,stl"); });
    EXPECT_NE(std::string(error.what()).find("geotiff"), std::string::npos);
}

}  // namespace
}  // namespace divemesh::io
