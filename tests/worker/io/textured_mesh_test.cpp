#include <algorithm>
#include <cmath>
#include <cstring>
#include <nlohmann/json.hpp>
#include <sstream>

#include "tests/worker/io/exported_folder.hpp"
#include "tests/worker/io/textured_square.hpp"
#include "tests/worker/io/unzipped.hpp"
#include "worker/io/exports.hpp"
#include "worker/io/glb_writer.hpp"
#include "worker/io/jpeg.hpp"
#include "worker/io/mesh_reader.hpp"
#include "worker/io/position_lattice.hpp"

namespace divemesh::io {
namespace {

constexpr GlbCompression kCompressions[] = {
    GlbCompression::None, GlbCompression::Quantised, GlbCompression::Meshopt};
constexpr float kStep_uv = 1.0F / 65535;

class TexturedMeshTest : public ExportedFolderTest {
protected:
    TexturedMesh written(GlbCompression compression) {
        write_glb(file("mesh.glb"), square_.mesh, &square_.texture, compression);
        return read_textured_glb(file("mesh.glb"));
    }
    // Returns the document of mesh.glb as another program would parse it.
    nlohmann::json document() const {
        const std::string bytes = read(file("mesh.glb"));
        return nlohmann::json::parse(bytes.substr(20, word_at(bytes, 12)));
    }
    std::string view(const nlohmann::json& index) const {
        const std::string bytes = read(file("mesh.glb"));
        const nlohmann::json view = document()["bufferViews"][index.get<std::size_t>()];
        return bytes.substr(28 + word_at(bytes, 12) + view["byteOffset"].get<std::size_t>(),
                            view["byteLength"].get<std::size_t>());
    }
    Error refusal(const nlohmann::json& document) const {
        const std::string bytes = read(file("mesh.glb"));
        std::string text = document.dump();
        text.resize((text.size() + 3) / 4 * 4, ' ');
        const auto size = static_cast<std::uint32_t>(text.size());
        const std::string changed = bytes.substr(0, 12) +
                                    std::string(reinterpret_cast<const char*>(&size), 4) + "JSON" +
                                    text + bytes.substr(20 + word_at(bytes, 12));
        return error_of([&] { parse_textured_glb(changed, "mesh.glb"); });
    }
    static std::uint32_t word_at(const std::string& bytes, std::size_t offset) {
        std::uint32_t value = 0;
        std::memcpy(&value, bytes.data() + offset, sizeof value);
        return value;
    }

    TexturedSquare square_;
};

// Returns the corners of the triangles as x, y, z, u, v, in an order that does not depend on how
// triangles and their corners are sorted.
std::vector<std::array<std::array<float, 5>, 3>> corners_of(const types::Mesh& mesh,
                                                            const types::TextureMap& texture) {
    std::vector<std::array<std::array<float, 5>, 3>> triangles(mesh.triangles.size());
    for (std::size_t i = 0; i < triangles.size(); ++i) {
        for (std::size_t k = 0; k < 3; ++k) {
            const Eigen::Vector3f& p = mesh.vertices[mesh.triangles[i][k]];
            const auto rounded = [](float value) { return std::round(1e4F * value) / 1e4F; };
            const bool is_textured = texture.atlas_of_triangle[i] != types::TextureMap::kUntextured;
            triangles[i][k] = {rounded(p.x()),
                               rounded(p.y()),
                               rounded(p.z()),
                               is_textured ? texture.uv[i][k].x() : 0.0F,
                               is_textured ? texture.uv[i][k].y() : 0.0F};
        }
        std::rotate(triangles[i].begin(),
                    std::min_element(triangles[i].begin(), triangles[i].end()),
                    triangles[i].end());
    }
    std::sort(triangles.begin(), triangles.end());
    return triangles;
}

void expect_same_corners(const std::vector<std::array<std::array<float, 5>, 3>>& read,
                         const std::vector<std::array<std::array<float, 5>, 3>>& truth,
                         float tolerance_m) {
    ASSERT_EQ(read.size(), truth.size());
    for (std::size_t i = 0; i < truth.size(); ++i)
        for (std::size_t k = 0; k < 3; ++k)
            for (std::size_t value = 0; value < 5; ++value)
                EXPECT_NEAR(
                    read[i][k][value], truth[i][k][value], value < 3 ? tolerance_m : kStep_uv)
                    << i << " " << k << " " << value;
}

TEST_F(TexturedMeshTest, AGlbGivesBackGeometryTextureCoordinatesAndImages) {
    const auto tolerance_m = static_cast<float>(position_lattice(square_.mesh).max_error_m());
    for (const GlbCompression compression : kCompressions) {
        const TexturedMesh read = written(compression);

        expect_same_corners(corners_of(read.mesh, read.texture),
                            corners_of(square_.mesh, square_.texture),
                            tolerance_m + 1e-4F);
        ASSERT_EQ(read.texture.jpegs.size(), 1U);  // the other atlas is not in use
        EXPECT_EQ(read.texture.jpegs[0], encode_jpeg(square_.texture.atlases[1]));
        EXPECT_EQ(std::count(read.texture.atlas_of_triangle.begin(),
                             read.texture.atlas_of_triangle.end(),
                             types::TextureMap::kUntextured),
                  1);
    }
}

// The corners of the square that the untextured triangle shares are two vertices each in the file.
TEST_F(TexturedMeshTest, VerticesAtTheSeamsAreOneAgain) {
    EXPECT_EQ(
        parse_glb((written(GlbCompression::Meshopt), read(file("mesh.glb"))), "").vertices.size(),
        7U);
    EXPECT_EQ(read_textured_glb(file("mesh.glb")).mesh.vertices.size(), 5U);
}

TEST_F(TexturedMeshTest, ColoursAndNormalsOfVerticesReadBack) {
    write_glb(file("mesh.glb"), tetrahedron(), nullptr, GlbCompression::None);

    const TexturedMesh read = read_textured_glb(file("mesh.glb"));

    EXPECT_TRUE(read.texture.jpegs.empty());
    const types::Mesh truth = tetrahedron();
    ASSERT_EQ(read.mesh.vertices.size(), truth.vertices.size());
    for (std::size_t i = 0; i < truth.vertices.size(); ++i) {
        const auto found =
            std::find_if(read.mesh.vertices.begin(), read.mesh.vertices.end(), [&](const auto& p) {
                return (p - truth.vertices[i]).norm() < 1e-6F;
            });
        ASSERT_NE(found, read.mesh.vertices.end());
        const auto vertex = static_cast<std::size_t>(found - read.mesh.vertices.begin());
        EXPECT_EQ(read.mesh.colors[vertex], truth.colors[i]);
        EXPECT_LT((read.mesh.normals[vertex] - truth.normals[i].normalized()).norm(), 1e-6F);
    }
}

TEST_F(TexturedMeshTest, AnObjIsTheTexturedMeshOfTheGlb) {
    const TexturedMesh shown = written(GlbCompression::Meshopt);

    export_reconstruction(open(), {ExportFormat::Obj}, std::nullopt, file("out"));

    auto files = unzipped(file("out/mesh_obj.zip"));
    EXPECT_EQ(files["atlas_0.jpg"], view(document()["images"][0]["bufferView"]));
    EXPECT_NE(files["mesh.mtl"].find("map_Kd atlas_0.jpg\n"), std::string::npos);
    TexturedMesh read{parse_obj(files["mesh.obj"], "mesh.obj"), {}};
    // The lines vt and f, read without our own parser; OBJ's v points up.
    std::istringstream lines(files["mesh.obj"]);
    std::vector<Eigen::Vector2f> uv;
    for (std::string line; std::getline(lines, line);) {
        Eigen::Vector2f value;
        std::array<std::array<unsigned, 3>, 3> f{};
        if (std::sscanf(line.c_str(), "vt %f %f", &value.x(), &value.y()) == 2)
            uv.emplace_back(value.x(), 1.0F - value.y());
        if (!line.starts_with("f ")) continue;
        const bool is_textured = std::sscanf(line.c_str(),
                                             "f %u/%u/%u %u/%u/%u %u/%u/%u",
                                             &f[0][0],
                                             &f[0][1],
                                             &f[0][2],
                                             &f[1][0],
                                             &f[1][1],
                                             &f[1][2],
                                             &f[2][0],
                                             &f[2][1],
                                             &f[2][2]) == 9;
        read.texture.atlas_of_triangle.push_back(is_textured ? 0 : types::TextureMap::kUntextured);
        auto& corners = read.texture.uv.emplace_back();
        for (std::size_t k = 0; k < 3; ++k)
            corners[k] = is_textured ? uv.at(f[k][1] - 1) : Eigen::Vector2f(0, 0);
    }
    ASSERT_EQ(read.texture.uv.size(), read.mesh.triangles.size());
    EXPECT_EQ(read.mesh.vertices.size(), 5U);
    expect_same_corners(
        corners_of(read.mesh, read.texture), corners_of(shown.mesh, shown.texture), 1e-6F);
}

TEST_F(TexturedMeshTest, WithoutTextureAnObjIsTheWholeMesh) {
    write_glb(file("mesh.glb"), square_.mesh, nullptr, GlbCompression::Meshopt);

    export_reconstruction(open(), {ExportFormat::Obj}, std::nullopt, file("out"));

    auto files = unzipped(file("out/mesh_obj.zip"));
    EXPECT_EQ(files.size(), 2U);
    EXPECT_EQ(parse_obj(files["mesh.obj"], "").vertices, tetrahedron().vertices);
}

TEST_F(TexturedMeshTest, AnAppearanceThatDoesNotFitIsRefused) {
    written(GlbCompression::None);
    const auto refused = [&](const char* pointer, const nlohmann::json& value) {
        nlohmann::json changed = document();
        changed[nlohmann::json::json_pointer(pointer)] = value;
        EXPECT_EQ(refusal(changed).code(), ErrorCode::BadData) << pointer;
    };
    refused("/meshes/0/primitives/0/material", 9);
    refused("/meshes/0/primitives/0/attributes/NORMAL", 7);
    refused("/meshes/0/primitives/0/attributes/TEXCOORD_0", -1);
    refused("/materials/0/pbrMetallicRoughness/baseColorTexture/index", 3);
    refused("/textures/0/source", 4);
    refused("/images/0/mimeType", "image/png");
    refused("/images/0/bufferView", "first");
    refused("/images/0/bufferView", 99);
}

}  // namespace
}  // namespace divemesh::io
