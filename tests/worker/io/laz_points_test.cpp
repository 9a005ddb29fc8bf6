#include "worker/io/laz_points.hpp"

#include <random>

#include "tests/worker/io/exported_folder.hpp"
#include "tests/worker/io/las_file.hpp"
#include "tests/worker/io/laz_decoder.hpp"
#include "worker/io/exports.hpp"
#include "worker/io/las_writer.hpp"

namespace divemesh::io {
namespace {

// A rippled surface, line by line, with noise, colours of which some are grey, and attributes.
types::Mesh rippled_surface(std::size_t num_points) {
    std::mt19937 random(5);
    std::normal_distribution<float> noise(0.0F, 0.001F);
    types::Mesh mesh;
    for (std::size_t i = 0; i < num_points; ++i) {
        const float x = 0.005F * static_cast<float>(i % 400);
        const float y = 0.005F * static_cast<float>(i / 400);
        mesh.vertices.emplace_back(
            x + noise(random), y + noise(random), 0.1F * std::sin(5 * x) - 0.3F * y);
        const auto grey = static_cast<std::uint8_t>(120 + 100 * std::sin(3 * x));
        const auto green = static_cast<std::uint8_t>(i % 7 < 2 ? grey : grey + random() % 30);
        const auto blue = static_cast<std::uint8_t>(i % 7 < 2 ? grey : 255 - grey);
        mesh.colors.push_back({grey, green, blue});
        mesh.sigma_m.push_back(0.002F + std::abs(noise(random)));
        mesh.num_observations.push_back(static_cast<std::uint32_t>(random() % 12));
    }
    return mesh;
}

class LazPointsTest : public ExportedFolderTest {
protected:
    // Expects that the LAZ file of a mesh has the points of its LAS file, byte by byte.
    void expect_the_points_of_las(const types::Mesh& mesh) const {
        write_las(file("mesh.las"), mesh, {});
        write_las(file("mesh.laz"), mesh, {}, LasStorage::Laszip);
        const std::string las = read(file("mesh.las"));
        const std::string laz = read(file("mesh.laz"));
        const std::vector<std::string> records = laz_records(laz);

        ASSERT_EQ(records.size(), mesh.vertices.size());
        const std::size_t first = LasFile(las).point_offset(0);
        for (std::size_t i = 0; i < records.size(); ++i)
            ASSERT_EQ(records[i], las.substr(first + i * 44, 44)) << i;
    }
};

TEST_F(LazPointsTest, ItsPointsAreThoseOfLasInAnyNumberOfChunks) {
    for (const std::size_t num_points : {0, 1, 2, 49'999, 50'000, 50'001, 130'000})
        expect_the_points_of_las(rippled_surface(num_points));
}

TEST_F(LazPointsTest, ItsPointsMayLieAnywhere) {
    std::mt19937 random(6);
    std::uniform_real_distribution<float> anywhere(-2e5F, 2e5F);
    types::Mesh mesh;
    for (int i = 0; i < 20'000; ++i) {
        mesh.vertices.emplace_back(anywhere(random), anywhere(random), anywhere(random));
        if (i % 3 == 0) mesh.vertices.back() = Eigen::Vector3f::Constant(i % 2 == 0 ? -2e5F : 2e5F);
        mesh.colors.push_back({static_cast<std::uint8_t>(random()),
                               static_cast<std::uint8_t>(random()),
                               static_cast<std::uint8_t>(random())});
        mesh.num_observations.push_back(static_cast<std::uint32_t>(random()));
    }

    expect_the_points_of_las(mesh);
}

TEST_F(LazPointsTest, PointsWithoutAttributesTakeNoBytesForThem) {
    types::Mesh mesh = rippled_surface(60'000);
    expect_the_points_of_las(mesh);
    const auto with_attributes = std::filesystem::file_size(file("mesh.laz"));
    mesh.colors.clear();
    mesh.sigma_m.clear();
    mesh.num_observations.clear();
    expect_the_points_of_las(mesh);

    EXPECT_LT(std::filesystem::file_size(file("mesh.laz")), with_attributes / 2);
}

TEST_F(LazPointsTest, PointsAtOnePlaceTakeHardlyAnyBytes) {
    types::Mesh mesh;
    mesh.vertices.assign(50'000, {1.0F, 2.0F, 3.0F});

    expect_the_points_of_las(mesh);

    EXPECT_LT(std::filesystem::file_size(file("mesh.laz")), 2'500U);
}

TEST_F(LazPointsTest, ItsHeaderIsThatOfLasWithTheCompressor) {
    export_reconstruction(
        open(), {ExportFormat::Las, ExportFormat::Laz}, std::nullopt, file("out"));
    const LasFile las(read(file("out/surface.las")));
    const LasFile laz(read(file("out/surface.laz")));

    EXPECT_EQ(laz.at<std::uint8_t>(104), 7 | 128);
    EXPECT_EQ(laz.at<std::uint64_t>(247), 4U);
    auto records = laz.records();
    const std::string compressor = records.at({"laszip encoded", 22204});
    records.erase({"laszip encoded", 22204});
    EXPECT_EQ(records, las.records());
    ASSERT_EQ(compressor.size(), 34U + 3 * 6);
    const LasFile content(compressor);
    EXPECT_EQ(content.at<std::uint16_t>(0), 3) << "chunks of layers";
    EXPECT_EQ(content.at<std::uint16_t>(2), 0) << "arithmetic coder";
    EXPECT_EQ(content.at<std::uint32_t>(12), 50'000U) << "points of a chunk";
    EXPECT_EQ(content.at<std::int64_t>(16), -1);
    EXPECT_EQ(content.at<std::int64_t>(24), -1);
    EXPECT_EQ(content.at<std::uint16_t>(32), 3) << "items: type, size and version";
    const std::vector<std::uint16_t> items = {10, 30, 3, 11, 6, 3, 14, 8, 3};
    for (std::size_t i = 0; i < items.size(); ++i)
        EXPECT_EQ(content.at<std::uint16_t>(34 + 2 * i), items[i]) << i;
}

TEST_F(LazPointsTest, AMeshThatItsIntegersCannotHoldIsRefused) {
    types::Mesh mesh = tetrahedron();
    mesh.vertices[1].x() = 3e38F;

    EXPECT_EQ(error_of([&] { write_las(file("mesh.laz"), mesh, {}, LasStorage::Laszip); }).code(),
              ErrorCode::BadData);
    EXPECT_FALSE(std::filesystem::exists(file("mesh.laz")));
}

TEST_F(LazPointsTest, TheSameMeshGivesTheSameBytes) {
    const types::Mesh mesh = rippled_surface(70'000);
    write_las(file("one.laz"), mesh, {}, LasStorage::Laszip);
    write_las(file("two.laz"), mesh, {}, LasStorage::Laszip);

    EXPECT_EQ(read(file("one.laz")), read(file("two.laz")));
}

}  // namespace
}  // namespace divemesh::io
