#include "worker/io/mesh_reader.hpp"

#include <algorithm>
#include <cstring>
#include <nlohmann/json.hpp>

#include "tests/worker/io/test_files.hpp"
#include "worker/io/glb_writer.hpp"
#include "worker/io/ply.hpp"

namespace divemesh::io {
namespace {

using nlohmann::json;

class MeshReaderTest : public FileTest {};

std::string word(std::uint32_t value) {
    std::string bytes(4, '\0');
    std::memcpy(bytes.data(), &value, 4);
    return bytes;
}

std::string glb(const json& document, const std::string& buffer) {
    const std::string text = document.dump();
    return "glTF" + word(2) + word(static_cast<std::uint32_t>(28 + text.size() + buffer.size())) +
           word(static_cast<std::uint32_t>(text.size())) + "JSON" + text +
           word(static_cast<std::uint32_t>(buffer.size())) + std::string("BIN\0", 4) + buffer;
}

std::string floats(const std::vector<float>& values) {
    return {reinterpret_cast<const char*>(values.data()), values.size() * sizeof(float)};
}

// Returns a document of one triangle with three positions and no indices.
json triangle_document() {
    return {{"asset", {{"version", "2.0"}}},
            {"scene", 0},
            {"scenes", {{{"nodes", {0}}}}},
            {"nodes", {{{"mesh", 0}, {"translation", {0.0, 0.0, 2.0}}}}},
            {"meshes", {{{"primitives", {{{"attributes", {{"POSITION", 0}}}}}}}}},
            {"accessors",
             {{{"bufferView", 0}, {"componentType", 5126}, {"type", "VEC3"}, {"count", 3}}}},
            {"bufferViews", {{{"buffer", 0}, {"byteLength", 36}}}},
            {"buffers", {{{"byteLength", 36}}}}};
}

const std::string& triangle_buffer() {
    static const std::string buffer = floats({0, 0, 0, 1, 0, 0, 0, 1, 0});
    return buffer;
}

TEST_F(MeshReaderTest, OurOwnGlbComesBackInTheWorldOfTheMesh) {
    const types::Mesh mesh = tetrahedron();
    write_glb(file("mesh.glb"), mesh, nullptr, GlbCompression::None);
    const types::Mesh read = read_mesh(file("mesh.glb"));
    ASSERT_EQ(read.vertices.size(), 4U);
    EXPECT_EQ(read.triangles.size(), 4U);
    for (const Eigen::Vector3f& vertex : mesh.vertices)
        EXPECT_TRUE(std::any_of(read.vertices.begin(), read.vertices.end(), [&](const auto& p) {
            return (p - vertex).norm() < 1e-6F;
        }));
}

TEST_F(MeshReaderTest, NodesMoveTheirMeshAndUpIsZ) {
    const types::Mesh mesh = parse_glb(glb(triangle_document(), triangle_buffer()), "a.glb");
    // glTF's (x, y, z) is our (x, -z, y).
    EXPECT_LT((mesh.vertices[2] - Eigen::Vector3f(0, -2, 1)).norm(), 1e-6F);
    ASSERT_EQ(mesh.triangles.size(), 1U);
}

TEST_F(MeshReaderTest, AHostileGlbIsRefused) {
    const auto refused = [](json document, const std::string& buffer) {
        EXPECT_EQ(error_of([&] { parse_glb(glb(document, buffer), "a.glb"); }).code(),
                  ErrorCode::BadData);
    };
    json document = triangle_document();
    document["accessors"][0]["count"] = 4'000'000'000U;
    refused(document, triangle_buffer());
    document = triangle_document();
    document["bufferViews"][0]["byteOffset"] = 18'000'000'000'000'000'000U;
    refused(document, triangle_buffer());
    document = triangle_document();
    document["nodes"][0]["children"] = {0};
    refused(document, triangle_buffer());
    document = triangle_document();
    document["scenes"][0]["nodes"] = {7};
    refused(document, triangle_buffer());
    document = triangle_document();
    document["accessors"] = "none";
    refused(document, triangle_buffer());
    refused(triangle_document(), "short");
    EXPECT_THROW(parse_glb("glTF", "a.glb"), Error);
    EXPECT_THROW(parse_glb("glTF" + word(2) + word(9) + word(~0U) + "JSON{}", "a.glb"), Error);
}

TEST_F(MeshReaderTest, NormalisedIntegersAreFractionsOfTheirLargestValue) {
    json document = triangle_document();
    document["accessors"][0]["componentType"] = 5122;
    document["accessors"][0]["normalized"] = true;
    document["bufferViews"][0]["byteStride"] = 8;
    std::string buffer(36, '\0');
    const std::int16_t corner[] = {32767, -32768, 0};
    std::memcpy(buffer.data() + 8, corner, sizeof corner);
    const types::Mesh mesh = parse_glb(glb(document, buffer), "a.glb");
    EXPECT_LT((mesh.vertices[1] - Eigen::Vector3f(1, -2, -1)).norm(), 1e-6F);
}

TEST_F(MeshReaderTest, ACompressedGlbThatLiesAboutItsSizesIsRefused) {
    write_glb(file("mesh.glb"), tetrahedron(), nullptr, GlbCompression::Meshopt);
    const std::string bytes = read(file("mesh.glb"));
    std::uint32_t num_json_bytes = 0;
    std::memcpy(&num_json_bytes, bytes.data() + 12, 4);
    const json document = json::parse(bytes.substr(20, num_json_bytes));
    const std::string buffer = bytes.substr(28 + num_json_bytes);
    ASSERT_EQ(parse_glb(glb(document, buffer), "a.glb").triangles.size(), 4U);
    const auto refused = [&](const char* member, const json& value) {
        for (const json& view : document["bufferViews"]) {
            json changed = document;
            // The reader needs the views of positions and indices, the first and the last.
            for (json& other : changed["bufferViews"])
                if (other["extensions"] == view["extensions"])
                    other["extensions"]["EXT_meshopt_compression"][member] = value;
            if (view != document["bufferViews"].front() && view != document["bufferViews"].back())
                continue;
            EXPECT_EQ(error_of([&] { parse_glb(glb(changed, buffer), "a.glb"); }).code(),
                      ErrorCode::BadData)
                << member << " " << value;
        }
    };
    refused("count", 3'000'000'000U);
    refused("count", 18'000'000'000'000'000'000U);
    refused("count", 0);
    refused("byteStride", 0);
    refused("byteStride", 3);
    refused("byteStride", 4096);
    refused("byteLength", 5);
    refused("byteLength", 18'000'000'000'000'000'000U);
    refused("byteOffset", buffer.size());
    refused("mode", "QUADS");
    refused("filter", "OCTAHEDRAL");
    refused("buffer", 1);
}

TEST_F(MeshReaderTest, AnObjOfPolygonsAndNegativeIndicesIsCutIntoFans) {
    const types::Mesh mesh =
        read_mesh(write("a.obj",
                        "# a square\nmtllib x.mtl\nv 0 0 0\nv 1 0 0\r\nv 1 1 0\n"
                        "v 0 1 0\nvt 0 0\nvn 0 0 1\nf 1/1/1 2//1 3 -1\n"));
    ASSERT_EQ(mesh.vertices.size(), 4U);
    const std::vector<std::array<std::uint32_t, 3>> fan = {{0, 1, 2}, {0, 2, 3}};
    EXPECT_EQ(mesh.triangles, fan);
}

TEST_F(MeshReaderTest, PointsAloneAreACloudWithTheirColours) {
    const types::Mesh cloud = parse_obj("v 1 2 3 1 0 0.5\nv 4 5 6 0 1 0\n", "a.obj");
    EXPECT_TRUE(cloud.triangles.empty());
    ASSERT_EQ(cloud.colors.size(), 2U);
    EXPECT_EQ(cloud.colors[0], (types::Color{255, 0, 128}));
}

TEST_F(MeshReaderTest, AnObjThatIsWrongNamesTheLine) {
    const auto message = [](const std::string& text) {
        return std::string(error_of([&] { parse_obj(text, "a.obj"); }).what());
    };
    EXPECT_NE(message("v 0 0 0\nf 1 2 3\n").find("a.obj:2"), std::string::npos);
    EXPECT_NE(message("v 0 0\n").find("a.obj:1"), std::string::npos);
    EXPECT_NE(message("v 0 0 nan\n").find("not a number"), std::string::npos);
    EXPECT_NE(message("v 0 0 0\nf 1 1\n").find("three corners"), std::string::npos);
    EXPECT_NE(message("v 0 0 0\nf 0 0 0\n").find("does not exist"), std::string::npos);
    EXPECT_NE(message("%PDF-1.4\n").find("no vertices"), std::string::npos);
}

TEST_F(MeshReaderTest, APlyIsToldByItsFirstBytes) {
    write_ply(file("mesh.dat"), tetrahedron());
    EXPECT_EQ(read_mesh(file("mesh.dat")).triangles, tetrahedron().triangles);
}

}  // namespace
}  // namespace divemesh::io
