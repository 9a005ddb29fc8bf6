#include "worker/io/glb_writer.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>

#include "tests/worker/io/test_files.hpp"
#include "tests/worker/io/textured_square.hpp"
#include "worker/io/mesh_reader.hpp"
#include "worker/io/position_lattice.hpp"

namespace divemesh::io {
namespace {

using nlohmann::json;

std::uint32_t word_at(const std::string& bytes, std::size_t offset) {
    std::uint32_t value = 0;
    std::memcpy(&value, bytes.data() + offset, sizeof value);
    return value;
}

constexpr GlbCompression kCompressions[] = {
    GlbCompression::None, GlbCompression::Quantised, GlbCompression::Meshopt};

class GlbTest : public FileTest {
protected:
    void write_and_parse(const types::Mesh& mesh,
                         const types::Texture* texture = nullptr,
                         GlbCompression compression = GlbCompression::None) {
        write_glb(file("mesh.glb"), mesh, texture, compression);
        bytes_ = read(file("mesh.glb"));
        document_ = json::parse(bytes_.substr(20, word_at(bytes_, 12)));
    }
    std::string view_bytes(const json& view) const {
        const std::size_t start = 20 + word_at(bytes_, 12) + 8;
        return bytes_.substr(start + view["byteOffset"].get<std::size_t>(),
                             view["byteLength"].get<std::size_t>());
    }
    // Returns the first values of an accessor that is not compressed.
    template <typename Value>
    std::vector<Value> values_of(const json& accessor_index, std::size_t num_values) const {
        const json& accessor = document_["accessors"][accessor_index.get<std::size_t>()];
        const std::string bytes =
            view_bytes(document_["bufferViews"][accessor["bufferView"].get<std::size_t>()]);
        std::vector<Value> values(num_values);
        EXPECT_GE(bytes.size(), num_values * sizeof(Value));
        std::memcpy(values.data(), bytes.data(), num_values * sizeof(Value));
        return values;
    }
    const json& primitive(std::size_t index = 0) const {
        return document_["meshes"][0]["primitives"][index];
    }
    const json& accessor(const json& index) const {
        return document_["accessors"][index.get<std::size_t>()];
    }
    // Returns which vertex of the first primitive is at a position. The file has floats.
    std::size_t vertex_at(const Eigen::Vector3f& position) const {
        const json& index = primitive()["attributes"]["POSITION"];
        const auto count = accessor(index)["count"].get<std::size_t>();
        const auto values = values_of<float>(index, 3 * count);
        for (std::size_t i = 0; i < count; ++i)
            if (Eigen::Map<const Eigen::Vector3f>(values.data() + 3 * i) == position) return i;
        ADD_FAILURE() << "no vertex is there";
        return 0;
    }
    // Checks the rules of glTF 2.0, sections 3.6.2.4 and 5.11, for buffers 0 and 1.
    void expect_views_in_bounds_and_aligned() const {
        for (const json& view : document_["bufferViews"]) {
            const auto& buffer = document_["buffers"][view["buffer"].get<std::size_t>()];
            EXPECT_LE(view["byteOffset"].get<std::size_t>() + view["byteLength"].get<std::size_t>(),
                      buffer["byteLength"].get<std::size_t>());
            EXPECT_EQ(view["byteOffset"].get<std::size_t>() % 4, 0U);
            EXPECT_EQ(view.value("byteStride", 4) % 4, 0);
        }
        EXPECT_LE(document_["buffers"][0]["byteLength"].get<std::size_t>(),
                  bytes_.size() - 28 - word_at(bytes_, 12));
    }

    std::string bytes_;
    json document_;
};

// Returns a wavy sheet of num x num vertices, 1 cm apart.
types::Mesh sheet(std::uint32_t num) {
    types::Mesh mesh;
    for (std::uint32_t y = 0; y < num; ++y)
        for (std::uint32_t x = 0; x < num; ++x)
            mesh.vertices.emplace_back(0.01F * static_cast<float>(x) - 1.0F,
                                       0.01F * static_cast<float>(y) + 5.0F,
                                       0.1F * std::sin(0.1F * static_cast<float>(x)) *
                                           std::cos(0.07F * static_cast<float>(y)));
    for (std::uint32_t y = 0; y + 1 < num; ++y)
        for (std::uint32_t x = 0; x + 1 < num; ++x) {
            const std::uint32_t i = y * num + x;
            mesh.triangles.push_back({i, i + 1, i + num});
            mesh.triangles.push_back({i + 1, i + num + 1, i + num});
        }
    return mesh;
}

// Returns the triangles of a sheet by the vertices of the grid that their corners are at,
// ascending.
std::vector<std::array<std::uint32_t, 3>> on_grid(const types::Mesh& mesh, std::uint32_t num) {
    std::vector<std::array<std::uint32_t, 3>> triangles;
    for (const auto& triangle : mesh.triangles) {
        auto& named = triangles.emplace_back();
        for (std::size_t i = 0; i < 3; ++i) {
            const Eigen::Vector3f& p = mesh.vertices[triangle[i]];
            named[i] = static_cast<std::uint32_t>(std::lround(100.0F * (p.y() - 5.0F))) * num +
                       static_cast<std::uint32_t>(std::lround(100.0F * (p.x() + 1.0F)));
        }
        std::rotate(named.begin(), std::min_element(named.begin(), named.end()), named.end());
    }
    std::sort(triangles.begin(), triangles.end());
    return triangles;
}

TEST_F(GlbTest, ChunksAddUpToTheLengthInTheHeader) {
    write_and_parse(tetrahedron());
    EXPECT_EQ(bytes_.substr(0, 4), "glTF");
    EXPECT_EQ(word_at(bytes_, 4), 2U);
    EXPECT_EQ(word_at(bytes_, 8), bytes_.size());
    EXPECT_EQ(word_at(bytes_, 12) % 4, 0U);
    EXPECT_EQ(20 + word_at(bytes_, 12) + 8 + word_at(bytes_, 20 + word_at(bytes_, 12)),
              bytes_.size());
}

TEST_F(GlbTest, PositionsStateTheirBoundsAndTheNodeTurnsZUpIntoYUp) {
    write_and_parse(tetrahedron());
    const json& position = document_["accessors"][primitive()["attributes"]["POSITION"].get<int>()];
    EXPECT_EQ(position["min"], json({0.0, 0.0, 0.0}));
    EXPECT_EQ(position["max"], json({1.0, 1.0, 1.0}));
    const auto q = document_["nodes"][0]["rotation"].get<std::vector<double>>();
    const Eigen::Quaterniond rotation(q[3], q[0], q[1], q[2]);
    EXPECT_LT((rotation * Eigen::Vector3d::UnitZ() - Eigen::Vector3d::UnitY()).norm(), 1e-12);
}

TEST_F(GlbTest, ColoursAreLinear) {
    write_and_parse(tetrahedron());
    const auto colors = values_of<std::uint16_t>(primitive()["attributes"]["COLOR_0"], 16);
    const std::size_t red = 4 * vertex_at({1, 0, 0});
    const std::size_t grey = 4 * vertex_at({0, 0, 1});
    EXPECT_EQ(colors[red], 65535);                        // sRGB 255
    EXPECT_EQ(colors[red + 1], 0);                        // sRGB 0
    EXPECT_EQ(colors[red + 3], 65535);                    // alpha
    EXPECT_NEAR(colors[grey] / 65535.0, 0.5029, 0.0005);  // sRGB 188: half the light
}

TEST_F(GlbTest, NormalsHaveUnitLength) {
    types::Mesh mesh = tetrahedron();
    mesh.normals[1].setZero();
    mesh.normals[2].setConstant(std::numeric_limits<float>::quiet_NaN());
    write_and_parse(mesh);
    const auto normals = values_of<float>(primitive()["attributes"]["NORMAL"], 12);
    for (std::size_t i = 0; i < 4; ++i)
        EXPECT_NEAR(std::hypot(normals[3 * i], normals[3 * i + 1], normals[3 * i + 2]), 1.0, 1e-6);
}

TEST_F(GlbTest, AnEmptyMeshIsAnEmptyScene) {
    for (const GlbCompression compression : kCompressions) {
        write_and_parse({}, nullptr, compression);
        EXPECT_FALSE(document_.contains("meshes"));
        EXPECT_FALSE(document_.contains("buffers"));
        EXPECT_EQ(word_at(bytes_, 8), bytes_.size());
    }
}

TEST_F(GlbTest, EveryCompressionGivesTheSameTrianglesBackWithinItsStatedError) {
    constexpr std::uint32_t kNum = 260;  // 67600 vertices: more than 16 bits can number
    const types::Mesh mesh = sheet(kNum);
    for (const GlbCompression compression : kCompressions) {
        write_and_parse(mesh, nullptr, compression);
        expect_views_in_bounds_and_aligned();
        const double error_m =
            document_["asset"].value(json::json_pointer("/extras/max_position_error_m"), 0.0);
        EXPECT_EQ(error_m > 0.0, compression != GlbCompression::None);
        const types::Mesh read = read_mesh(file("mesh.glb"));
        EXPECT_EQ(on_grid(read, kNum), on_grid(mesh, kNum));
        for (const Eigen::Vector3f& p : read.vertices) {
            const auto x = std::lround(100.0F * (p.x() + 1.0F));
            const auto y = std::lround(100.0F * (p.y() - 5.0F));
            const auto vertex = static_cast<std::size_t>(y * std::int64_t{kNum} + x);
            ASSERT_LT((p - mesh.vertices[vertex]).norm(), error_m + 2e-6);
        }
    }
}

TEST_F(GlbTest, QuantisedPositionsStateIntegerBoundsAndTheirExtension) {
    write_and_parse(tetrahedron(), nullptr, GlbCompression::Quantised);
    const json& position = accessor(primitive()["attributes"]["POSITION"]);
    EXPECT_EQ(position["componentType"], 5123);
    EXPECT_EQ(position["min"], json({0, 0, 0}));
    EXPECT_EQ(position["max"], json({16383, 16383, 16383}));  // 14 bits suffice for a sigma of 1 mm
    EXPECT_EQ(document_["extensionsRequired"], json({"KHR_mesh_quantization"}));
}

// EXT_meshopt_compression, sections "Mode 0" and "Mode 1".
TEST_F(GlbTest, CompressedViewsBeginAsTheirFormatsRequireAndNameAFallbackBuffer) {
    write_and_parse(tetrahedron(), nullptr, GlbCompression::Meshopt);
    EXPECT_EQ(document_["buffers"][1]["extensions"]["EXT_meshopt_compression"]["fallback"], true);
    EXPECT_EQ(document_["extensionsRequired"],
              json({"KHR_mesh_quantization", "EXT_meshopt_compression"}));
    for (const json& view : document_["bufferViews"]) {
        const json& compression = view["extensions"]["EXT_meshopt_compression"];
        const std::string bytes = view_bytes(compression);
        const bool is_triangles = compression["mode"] == "TRIANGLES";
        EXPECT_EQ(static_cast<unsigned char>(bytes[0]), is_triangles ? 0xe1 : 0xa0);
        EXPECT_EQ(view["byteLength"],
                  compression["count"].get<int>() * compression["byteStride"].get<int>());
        EXPECT_EQ(view.contains("byteStride"), !is_triangles);
    }
}

TEST_F(GlbTest, ATexturedSquareShowsTheTexelOfEachCorner) {
    const TexturedSquare square;
    write_and_parse(square.mesh, &square.texture, GlbCompression::None);
    expect_views_in_bounds_and_aligned();
    ASSERT_EQ(document_["images"].size(), 1U);  // the atlas that no triangle uses is left out
    EXPECT_EQ(document_["images"][0]["mimeType"], "image/jpeg");
    const std::string jpeg = view_bytes(
        document_["bufferViews"][document_["images"][0]["bufferView"].get<std::size_t>()]);
    const cv::Mat image =
        cv::imdecode(std::vector<char>(jpeg.begin(), jpeg.end()), cv::IMREAD_COLOR);
    const auto uv = values_of<float>(primitive()["attributes"]["TEXCOORD_0"], 8);
    const auto texel = [&](const Eigen::Vector3f& corner) {
        const std::size_t i = 2 * vertex_at(corner);
        return image.at<cv::Vec3b>(static_cast<int>(64 * uv[i + 1]), static_cast<int>(64 * uv[i]));
    };
    const auto expect_color = [](const cv::Vec3b& color, const cv::Scalar& truth) {
        for (int i = 0; i < 3; ++i) EXPECT_NEAR(color[i], truth[i], 6.0);
    };
    expect_color(texel({0, 0, 0}), TexturedSquare::kBottomLeft);
    expect_color(texel({0, 1, 0}), TexturedSquare::kTopLeft);
}

TEST_F(GlbTest, TrianglesWithoutTextureHaveColoursAndTheirOwnPrimitive) {
    const TexturedSquare square;
    for (const GlbCompression compression : kCompressions) {
        write_and_parse(square.mesh, &square.texture, compression);
        ASSERT_EQ(document_["meshes"][0]["primitives"].size(), 2U);
        EXPECT_FALSE(primitive(0)["attributes"].contains("COLOR_0"));
        EXPECT_FALSE(primitive(1)["attributes"].contains("TEXCOORD_0"));
        EXPECT_EQ(accessor(primitive(1)["attributes"]["COLOR_0"])["count"], 3);
        EXPECT_EQ(read_mesh(file("mesh.glb")).triangles.size(), 3U);
    }
}

TEST_F(GlbTest, AVertexIsRepeatedWhereTextureCoordinatesDiffer) {
    TexturedSquare square;
    write_and_parse(square.mesh, &square.texture);
    EXPECT_EQ(accessor(primitive()["attributes"]["POSITION"])["count"], 4);
    square.texture.uv[1][1] = {0.5F, 0.5F};
    write_and_parse(square.mesh, &square.texture);
    EXPECT_EQ(accessor(primitive()["attributes"]["POSITION"])["count"], 5);
}

TEST_F(GlbTest, ATextureOfAnotherMeshIsRefused) {
    const auto refused = [&](const types::Texture& texture) {
        EXPECT_EQ(error_of([&] {
                      write_glb(
                          file("mesh.glb"), TexturedSquare().mesh, &texture, GlbCompression::None);
                  }).code(),
                  ErrorCode::InvalidArgument);
    };
    TexturedSquare square;
    square.texture.atlas_of_triangle[0] = 2;
    refused(square.texture);
    square = {};
    square.texture.uv[0][2].x() = std::numeric_limits<float>::quiet_NaN();
    refused(square.texture);
    square = {};
    square.texture.uv.pop_back();
    refused(square.texture);
    square = {};
    square.texture.atlases[0] = cv::Mat(4, 4, CV_8UC1);
    refused(square.texture);
    EXPECT_TRUE(std::filesystem::is_empty(file("")));
}

TEST(PositionLatticeTest, HasTheFewestBitsThatKeepATenthOfSigma) {
    types::Mesh mesh;
    mesh.vertices = {{0, 0, 0}, {10, 1, 2}};
    const auto bits_of = [&](float sigma_m) {
        mesh.sigma_m = {sigma_m, 1.0F};
        return std::log2(10.0 / position_lattice(mesh).step_m + 1.0);
    };
    EXPECT_DOUBLE_EQ(bits_of(0.01F), 14.0);    // 0.53 mm
    EXPECT_DOUBLE_EQ(bits_of(0.005F), 15.0);   // 0.26 mm
    EXPECT_DOUBLE_EQ(bits_of(0.0001F), 16.0);  // 0.13 mm: more than asked for
    EXPECT_DOUBLE_EQ(bits_of(0.0F), 14.0);     // the other vertex's
}

}  // namespace
}  // namespace divemesh::io
