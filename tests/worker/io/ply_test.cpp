#include "worker/io/ply.hpp"

#include "tests/worker/io/test_files.hpp"

namespace divemesh::io {
namespace {

class PlyTest : public FileTest {};

const char kHeaderOfOneTriangle[] =
    "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n"
    "property float z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n";

TEST_F(PlyTest, AMeshSurvivesTheWayThroughAFile) {
    const types::Mesh written = tetrahedron();
    write_ply(file("mesh.ply"), written);
    const types::Mesh mesh = read_ply(file("mesh.ply"));
    EXPECT_EQ(mesh.vertices, written.vertices);
    EXPECT_EQ(mesh.colors, written.colors);
    EXPECT_EQ(mesh.sigma_m, written.sigma_m);
    EXPECT_EQ(mesh.sigma_local_m, written.sigma_local_m);
    EXPECT_EQ(mesh.num_observations, written.num_observations);
    EXPECT_EQ(mesh.triangles, written.triangles);
}

TEST_F(PlyTest, VerticesTakeThirtyNineBytesAndTrianglesThirteen) {
    write_ply(file("mesh.ply"), tetrahedron());
    const std::string bytes = read(file("mesh.ply"));
    const std::string end = "end_header\n";
    EXPECT_EQ(bytes.size() - bytes.find(end) - end.size(), 4U * 39U + 4U * 13U);
}

TEST_F(PlyTest, WrittenNormalsAreUnitLengthEvenWhereTheMeshHasNone) {
    types::Mesh written = tetrahedron();
    written.normals.clear();
    write_ply(file("mesh.ply"), written);
    const types::Mesh mesh = read_ply(file("mesh.ply"));
    ASSERT_EQ(mesh.normals.size(), 4U);
    for (std::size_t i = 0; i < mesh.normals.size(); ++i) {
        EXPECT_NEAR(mesh.normals[i].norm(), 1.0F, 1e-6F);
        EXPECT_GT(mesh.normals[i].dot(mesh.vertices[i] - Eigen::Vector3f::Constant(0.25F)), 0.0F);
    }
}

TEST_F(PlyTest, ACloudKeepsItsPointsAndColours) {
    const std::vector<Eigen::Vector3f> points{{1, 2, 3}, {4, 5, 6}};
    const std::vector<types::Color> colors{{1, 2, 3}, {4, 5, 6}};
    CloudPlyWriter cloud(file("cloud.ply"), 2);
    for (int i = 0; i < 2; ++i) cloud.add(points[i], colors[i]);
    cloud.commit();
    const types::Mesh mesh = read_ply(file("cloud.ply"));
    EXPECT_EQ(mesh.vertices, points);
    EXPECT_EQ(mesh.colors, colors);
    EXPECT_TRUE(mesh.triangles.empty());
}

TEST_F(PlyTest, ReadsAsciiWithUnknownPropertiesAndPolygons) {
    const types::Mesh mesh = parse_ply(
        "ply\r\nformat ascii 1.0\r\ncomment a square\r\nelement vertex 4\r\nproperty double x\r\n"
        "property float quality\r\nproperty double y\r\nproperty double z\r\n"
        "element face 1\r\nproperty list uchar int vertex_index\r\nproperty uchar flags\r\n"
        "end_header\r\n0 9 0 0\r\n1 9 0 0\r\n1 9 1 0\r\n0 9 1 0\r\n4 0 1 2 3 7\r\n",
        "square.ply");
    ASSERT_EQ(mesh.vertices.size(), 4U);
    EXPECT_EQ(mesh.vertices[2], Eigen::Vector3f(1, 1, 0));
    ASSERT_EQ(mesh.triangles.size(), 2U);
    EXPECT_EQ(mesh.triangles[1], (std::array<std::uint32_t, 3>{0, 2, 3}));
}

TEST_F(PlyTest, ReadsBigEndian) {
    const std::string header =
        "ply\nformat binary_big_endian 1.0\nelement vertex 1\nproperty float x\nproperty short y\n"
        "property float z\nend_header\n";
    const std::string body("\x3f\x80\x00\x00\x00\x02\xc0\x40\x00\x00", 10);
    EXPECT_EQ(parse_ply(header + body, "p.ply").vertices.at(0), Eigen::Vector3f(1, 2, -3));
}

TEST_F(PlyTest, AHugeCountIsRefusedBeforeAnythingIsAllocated) {
    const std::string text =
        "ply\nformat binary_little_endian 1.0\nelement vertex 999999999999999\nproperty float x\n"
        "property float y\nproperty float z\nend_header\nabc";
    EXPECT_EQ(error_of([&] { parse_ply(text, "big.ply"); }).code(), ErrorCode::BadData);
}

TEST_F(PlyTest, DamagedFilesAreRefused) {
    const std::string start = kHeaderOfOneTriangle;
    const std::string vertices = "0 0 0\n1 0 0\n0 1 0\n";
    for (const std::string& text : {std::string("no ply"),
                                    std::string("ply\nformat ascii 1.0\n"),
                                    start + "0 0 0\n1 0 0\n0 1\n",
                                    start + vertices + "3 0 1 3\n",
                                    start + vertices + "3 0 1 -1\n",
                                    start + vertices + "200000 0 1 2\n",
                                    start + "0 0 0\n1 0 0\n0 nan 0\n3 0 1 2\n",
                                    start + "0 0 0\n1 0 zero\n0 1 0\n3 0 1 2\n"}) {
        const Error error = error_of([&] { parse_ply(text, "bad.ply"); });
        EXPECT_EQ(error.code(), ErrorCode::BadData) << text;
        EXPECT_EQ(std::string(error.what()).rfind("bad.ply: ", 0), 0U) << error.what();
    }
}

// The faces between the lists could refer to vertices that the second list removes.
TEST_F(PlyTest, ASecondListOfVerticesIsRefused) {
    const std::string vertex = "property float x\nproperty float y\nproperty float z\n";
    const std::string text = "ply\nformat ascii 1.0\nelement vertex 3\n" + vertex +
                             "element face 1\nproperty list uchar int vertex_indices\n"
                             "element vertex 1\n" +
                             vertex + "end_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n0 0 0\n";
    EXPECT_EQ(error_of([&] { parse_ply(text, "two.ply"); }).code(), ErrorCode::BadData);
}

TEST_F(PlyTest, ANumberOfObservationsThatIsNoneIsZero) {
    const types::Mesh mesh = parse_ply(
        "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\n"
        "property float z\nproperty float num_observations\nend_header\n0 0 0 nan\n",
        "nan.ply");
    EXPECT_EQ(mesh.num_observations.at(0), 0U);
}

TEST_F(PlyTest, ATriangleOfMissingVerticesIsNotWritten) {
    types::Mesh mesh = tetrahedron();
    mesh.triangles[0][0] = 4;
    EXPECT_EQ(error_of([&] { write_ply(file("mesh.ply"), mesh); }).code(),
              ErrorCode::InvalidArgument);
}

}  // namespace
}  // namespace divemesh::io
