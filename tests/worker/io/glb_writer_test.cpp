#include "worker/io/glb_writer.hpp"

#include <Eigen/Geometry>
#include <cmath>
#include <cstring>
#include <limits>
#include <nlohmann/json.hpp>

#include "tests/worker/io/test_files.hpp"

namespace divemesh::io {
namespace {

using nlohmann::json;

std::uint32_t word_at(const std::string& bytes, std::size_t offset) {
    std::uint32_t value = 0;
    std::memcpy(&value, bytes.data() + offset, sizeof value);
    return value;
}

class GlbTest : public FileTest {
protected:
    void write_and_parse(const types::Mesh& mesh) {
        write_glb(file("mesh.glb"), mesh);
        bytes_ = read(file("mesh.glb"));
        document_ = json::parse(bytes_.substr(20, word_at(bytes_, 12)));
    }
    // Returns a pointer to the first bytes of an attribute of the first primitive.
    template <typename Value>
    std::vector<Value> values_of(const json& accessor_index, std::size_t num_values) const {
        const json& accessor = document_["accessors"][accessor_index.get<std::size_t>()];
        const json& view = document_["bufferViews"][accessor["bufferView"].get<std::size_t>()];
        const std::size_t start = 20 + word_at(bytes_, 12) + 8;
        std::vector<Value> values(num_values);
        std::memcpy(values.data(),
                    bytes_.data() + start + view["byteOffset"].get<std::size_t>(),
                    num_values * sizeof(Value));
        return values;
    }
    const json& primitive() const { return document_["meshes"][0]["primitives"][0]; }

    std::string bytes_;
    json document_;
};

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
    EXPECT_EQ(colors[4], 65535);                        // sRGB 255
    EXPECT_EQ(colors[5], 0);                            // sRGB 0
    EXPECT_EQ(colors[7], 65535);                        // alpha
    EXPECT_NEAR(colors[12] / 65535.0, 0.5029, 0.0005);  // sRGB 188: half the light
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
    write_and_parse({});
    EXPECT_FALSE(document_.contains("meshes"));
    EXPECT_FALSE(document_.contains("buffers"));
    EXPECT_EQ(word_at(bytes_, 8), bytes_.size());
}

}  // namespace
}  // namespace divemesh::io
