#include "worker/io/las_writer.hpp"

#include <proj.h>

#include "tests/worker/io/exported_folder.hpp"
#include "tests/worker/io/las_file.hpp"
#include "worker/io/exports.hpp"

namespace divemesh::io {
namespace {

class LasWriterTest : public ExportedFolderTest {
protected:
    LasFile export_it(const std::optional<types::GeographicPosition>& position = {}) const {
        const auto names =
            export_reconstruction(open(), {ExportFormat::Las}, position, file("out"));
        EXPECT_EQ(names[0], "surface.las");
        return LasFile(read(file("out/surface.las")));
    }
    LasFile written(const types::Mesh& mesh) const {
        write_las(file("mesh.las"), mesh, {});
        return LasFile(read(file("mesh.las")));
    }
};

TEST_F(LasWriterTest, ItsHeaderIsThatOfVersion1_4) {
    const LasFile las = export_it();

    EXPECT_EQ(las.text(0, 4), "LASF");
    EXPECT_EQ(las.at<std::uint16_t>(6), 16) << "the coordinate system is well-known text";
    EXPECT_EQ(las.at<std::uint8_t>(24), 1);
    EXPECT_EQ(las.at<std::uint8_t>(25), 4);
    EXPECT_EQ(las.text(58, 32), "divemesh");
    EXPECT_EQ(las.at<std::uint16_t>(90), 175) << "24 June";
    EXPECT_EQ(las.at<std::uint16_t>(92), 2014);
    EXPECT_EQ(las.at<std::uint16_t>(94), 375);
    EXPECT_EQ(las.at<std::uint8_t>(104), 7);
    EXPECT_EQ(las.at<std::uint16_t>(105), 44);
    for (std::size_t offset = 107; offset < 131; offset += 4)
        EXPECT_EQ(las.at<std::uint32_t>(offset), 0U) << "legacy count";
    EXPECT_EQ(las.at<std::uint64_t>(247), 4U);
    EXPECT_EQ(las.at<std::uint64_t>(255), 4U) << "first returns";
    EXPECT_EQ(las.at<std::uint64_t>(263), 0U);
    EXPECT_EQ(las.size(), las.point_offset(4));
}

TEST_F(LasWriterTest, APointKeepsATenthOfAMillimetreAndItsAttributes) {
    types::Mesh mesh = tetrahedron();
    mesh.vertices[1] = {123.45678F, -0.98765F, -7.65432F};

    const LasFile las = written(mesh);

    for (std::size_t i = 0; i < 4; ++i)
        EXPECT_LT((las.point(i) - mesh.vertices[i].cast<double>()).cwiseAbs().maxCoeff(), 5.1e-5);
    const std::size_t second = las.point_offset(1);
    EXPECT_EQ(las.at<std::uint8_t>(second + 14), 0x11) << "return 1 of 1";
    EXPECT_EQ(las.at<std::uint16_t>(second + 30), 255 * 256) << "red";
    EXPECT_EQ(las.at<std::uint16_t>(second + 32), 0) << "green";
    EXPECT_EQ(las.at<float>(second + 36), 0.002F);
    EXPECT_EQ(las.at<std::uint32_t>(second + 40), 2U);
}

TEST_F(LasWriterTest, ItsBoundsAreThoseOfItsPoints) {
    types::Mesh mesh = tetrahedron();
    mesh.vertices[1] = {123.45678F, -0.98765F, -7.65432F};

    const LasFile las = written(mesh);

    Eigen::Vector3d low = las.point(0);
    Eigen::Vector3d high = low;
    for (std::size_t i = 1; i < 4; ++i) {
        low = low.cwiseMin(las.point(i));
        high = high.cwiseMax(las.point(i));
    }
    for (std::size_t axis = 0; axis < 3; ++axis) {
        EXPECT_NEAR(las.at<double>(179 + 16 * axis), high[static_cast<int>(axis)], 1e-9);
        EXPECT_NEAR(las.at<double>(187 + 16 * axis), low[static_cast<int>(axis)], 1e-9);
    }
}

TEST_F(LasWriterTest, ItsExtraBytesAreDescribed) {
    const std::string extra = export_it().records().at({"LASF_Spec", 4});

    ASSERT_EQ(extra.size(), 2U * 192);
    EXPECT_EQ(extra[2], 9) << "float";
    EXPECT_EQ(extra[3], 1) << "no data is stated";
    EXPECT_STREQ(extra.c_str() + 4, "sigma");
    EXPECT_EQ(extra.substr(40, 8), std::string(8, '\0')) << "no data";
    EXPECT_STREQ(extra.c_str() + 160, "along the normal, m; 0: unknown");
    EXPECT_EQ(extra[192 + 2], 5) << "unsigned long";
    EXPECT_STREQ(extra.c_str() + 192 + 4, "observations");
}

TEST_F(LasWriterTest, ATextStatesTheVerdict) {
    const std::string text = export_it().records().at({"LASF_Spec", 3});

    EXPECT_TRUE(text.starts_with("divemesh 0.1.0; verdict: usable with restrictions"));
    EXPECT_TRUE(text.ends_with('\0'));
}

// PROJ's own understanding of a coordinate system in well-known text.
class CoordinateSystem {
public:
    explicit CoordinateSystem(const std::string& text)
        : context_(proj_context_create()), system_(proj_create(context_, text.c_str())) {}
    ~CoordinateSystem() {
        proj_destroy(system_);
        proj_context_destroy(context_);
    }
    CoordinateSystem(const CoordinateSystem&) = delete;
    CoordinateSystem& operator=(const CoordinateSystem&) = delete;

    PJ_TYPE type() const { return system_ == nullptr ? PJ_TYPE_UNKNOWN : proj_get_type(system_); }
    std::string definition() const {
        const char* text = proj_as_proj_string(context_, system_, PJ_PROJ_5, nullptr);
        return text == nullptr ? "" : text;
    }

private:
    PJ_CONTEXT* context_;
    PJ* system_;
};

TEST_F(LasWriterTest, WithAPositionItsPointsAreInUtm) {
    const types::GeographicPosition position{-33.0, 153.0, 90.0};  // on the central meridian

    const LasFile las = export_it(position);

    const CoordinateSystem system(las.records().at({"LASF_Projection", 2112}));
    EXPECT_EQ(system.type(), PJ_TYPE_PROJECTED_CRS);
    EXPECT_TRUE(system.definition().starts_with("+proj=utm +zone=56 +south"))
        << system.definition();
    const Eigen::Vector3d first = las.point(0);  // the origin; vertex 1 is 1 m to the east
    EXPECT_NEAR(first.x(), 500'000.0, 1e-4);
    EXPECT_NEAR(first.z(), 0.0, 1e-9);
    EXPECT_LT((las.point(1) - first - Eigen::Vector3d(0.9996, 0.0, 0.0)).norm(), 1e-4);
}

TEST_F(LasWriterTest, ATextSaysThatNorthIsNotKnown) {
    const LasFile las = export_it(types::GeographicPosition{54.0, 12.0, std::nullopt});

    EXPECT_NE(las.records().at({"LASF_Spec", 3}).find("NORTH NOT KNOWN"), std::string::npos);
}

TEST_F(LasWriterTest, WithoutAPositionItsSystemIsLocal) {
    const CoordinateSystem system(export_it().records().at({"LASF_Projection", 2112}));

    EXPECT_EQ(system.type(), PJ_TYPE_ENGINEERING_CRS);
}

TEST_F(LasWriterTest, AMeshWithoutVerticesIsAFileWithoutPoints) {
    const LasFile las = written({});

    EXPECT_EQ(las.at<std::uint64_t>(247), 0U);
    EXPECT_EQ(las.at<double>(179), 0.0);
    EXPECT_EQ(las.size(), las.point_offset(0));
}

TEST_F(LasWriterTest, AMeshThatItsIntegersCannotHoldIsRefused) {
    types::Mesh mesh = tetrahedron();
    mesh.vertices[1].x() = 3e38F;

    EXPECT_EQ(error_of([&] { written(mesh); }).code(), ErrorCode::BadData);
    EXPECT_FALSE(std::filesystem::exists(file("mesh.las")));
}

TEST_F(LasWriterTest, ItsHeaderCountsMorePointsThanFitIn32Bits) {
    constexpr std::uint64_t kNumPoints = (std::uint64_t{1} << 33) + 5;

    for (const LasStorage storage : {LasStorage::Plain, LasStorage::Laszip}) {
        const LasFile las(las_header({}, {}, kNumPoints, storage));

        EXPECT_EQ(las.at<std::uint64_t>(247), kNumPoints);
        EXPECT_EQ(las.at<std::uint64_t>(255), kNumPoints) << "first returns";
    }
}

TEST_F(LasWriterTest, TheSameMeshGivesTheSameBytes) {
    export_it();
    const std::string first = read(file("out/surface.las"));
    export_it();

    EXPECT_EQ(read(file("out/surface.las")), first);
}

}  // namespace
}  // namespace divemesh::io
