#include "worker/io/ply_zip.hpp"

#include <cstring>
#include <map>
#include <sstream>

#include "tests/worker/io/test_files.hpp"
#include "tests/worker/io/textured_square.hpp"
#include "tests/worker/io/unzipped.hpp"
#include "worker/io/jpeg.hpp"

namespace divemesh::io {
namespace {

// A reader of the PLY files that MeshLab writes: it takes sizes and names from the header, and from
// the comments the images, which texnumber counts.
class MeshLabPly {
public:
    struct Face {
        std::vector<double> vertex_indices;
        std::vector<double> texcoord;
        double texnumber = 0.0;
    };

    explicit MeshLabPly(const std::string& bytes) : bytes_(bytes) {
        std::istringstream header(bytes);
        std::vector<std::pair<std::string, std::size_t>> elements;
        std::map<std::string, std::vector<std::vector<std::string>>> properties;
        for (std::string line; std::getline(header, line) && line != "end_header";) {
            std::istringstream stream(line);
            std::vector<std::string> words;
            for (std::string word; stream >> word;) words.push_back(word);
            if (words[0] == "comment") comments.push_back(line.substr(8));
            if (words[0] == "comment" && words[1] == "TextureFile") images.push_back(words[2]);
            if (words[0] == "element") elements.emplace_back(words[1], std::stoul(words[2]));
            if (words[0] == "property") properties[elements.back().first].push_back(words);
        }
        at_ = bytes.find("end_header\n") + 11;
        for (const auto& [name, count] : elements)
            for (std::size_t i = 0; i < count; ++i) {
                std::map<std::string, std::vector<double>> values;
                for (const auto& words : properties[name])
                    values[words.back()] = words[1] == "list" ? list(words) : scalar(words[1]);
                if (name == "vertex") vertices.push_back(values);
                if (name == "face")
                    faces.push_back({values.at("vertex_indices"),
                                     values["texcoord"],
                                     values.contains("texnumber") ? values["texnumber"][0] : -1.0});
            }
        EXPECT_EQ(at_, bytes.size());
    }

    std::vector<std::string> comments;
    std::vector<std::string> images;
    std::vector<std::map<std::string, std::vector<double>>> vertices;
    std::vector<Face> faces;

private:
    template <typename Value>
    double read() {
        Value value{};
        std::memcpy(&value, bytes_.data() + at_, sizeof value);
        at_ += sizeof value;
        return static_cast<double>(value);
    }
    std::vector<double> scalar(const std::string& type) {
        if (type == "uchar") return {read<std::uint8_t>()};
        if (type == "int") return {read<std::int32_t>()};
        EXPECT_EQ(type, "float");
        return {read<float>()};
    }
    std::vector<double> list(const std::vector<std::string>& words) {
        std::vector<double> values;
        const auto count = static_cast<int>(scalar(words[2])[0]);
        for (int i = 0; i < count; ++i) values.push_back(scalar(words[3])[0]);
        return values;
    }

    const std::string& bytes_;
    std::size_t at_ = 0;
};

class PlyZipTest : public FileTest {
protected:
    PlyZipTest() {
        static_cast<types::TextureMap&>(texture_) = square_.texture;
        texture_.jpegs = {"not in use", encode_jpeg(square_.texture.atlases[1])};
        square_.mesh.colors[4] = {7, 8, 9};
    }
    std::map<std::string, std::string> written(const StoredTexture* texture) const {
        write_ply_zip(file("mesh.zip"), square_.mesh, texture, "verdict: good");
        return unzipped(file("mesh.zip"));
    }

    TexturedSquare square_;
    StoredTexture texture_;
};

// The square shows one colour in each quarter, which the atlas fixes; a point of a triangle has the
// colour of the image where its coordinates lead, v up.
TEST_F(PlyZipTest, PointsOfTheSurfaceHaveTheColoursOfThePhotograph) {
    auto files = written(&texture_);
    const MeshLabPly ply(files["mesh.ply"]);
    ASSERT_EQ(ply.vertices.size(), 5U);
    ASSERT_EQ(ply.faces.size(), 3U);
    ASSERT_EQ(ply.images, std::vector<std::string>{"atlas_1.jpg"});
    int num_compared = 0;
    for (const MeshLabPly::Face& face : ply.faces) {
        ASSERT_EQ(face.texcoord.size(), 6U);
        if (face.texnumber < 0.0) continue;
        const cv::Mat image =
            decode_jpeg(files.at(ply.images.at(static_cast<std::size_t>(face.texnumber))));
        for (const Eigen::Vector3d& weights :
             {Eigen::Vector3d(0.8, 0.1, 0.1), {0.1, 0.8, 0.1}, {0.1, 0.1, 0.8}}) {
            double x = 0.0, y = 0.0, u = 0.0, v = 0.0;
            for (std::size_t k = 0; k < 3; ++k) {
                const double weight = weights[static_cast<Eigen::Index>(k)];
                const auto& vertex =
                    ply.vertices.at(static_cast<std::size_t>(face.vertex_indices[k]));
                x += weight * vertex.at("x")[0];
                y += weight * vertex.at("y")[0];
                u += weight * face.texcoord[2 * k];
                v += weight * face.texcoord[2 * k + 1];
            }
            const auto color = image.at<cv::Vec3b>(static_cast<int>((1.0 - v) * image.rows),
                                                   static_cast<int>(u * image.cols));
            const cv::Scalar truth =
                x < 0.5   ? (y > 0.5 ? TexturedSquare::kTopLeft : TexturedSquare::kBottomLeft)
                : y > 0.5 ? cv::Scalar(40, 200, 40)
                          : cv::Scalar(128, 128, 128);
            for (int channel = 0; channel < 3; ++channel)
                EXPECT_NEAR(color[channel], truth[channel], 8.0) << x << " " << y;
            ++num_compared;
        }
    }
    EXPECT_EQ(num_compared, 6);
}

TEST_F(PlyZipTest, ATriangleWithoutTextureNamesNoImageAndHasTheColoursOfItsVertices) {
    auto files = written(&texture_);
    EXPECT_EQ(files.size(), 2U);
    const MeshLabPly ply(files["mesh.ply"]);
    EXPECT_EQ(ply.faces[0].texnumber, 0.0);
    EXPECT_EQ(ply.faces[2].texnumber, -1.0);
    EXPECT_EQ(ply.faces[2].vertex_indices, (std::vector<double>{1, 4, 2}));
    EXPECT_EQ(ply.vertices[4].at("red")[0], 7.0);
    EXPECT_EQ(ply.vertices[4].at("blue")[0], 9.0);
}

TEST_F(PlyZipTest, TrianglesNameTheImageOfTheirAtlas) {
    texture_.atlas_of_triangle = {1, 0, types::TextureMap::kUntextured};
    auto files = written(&texture_);
    const MeshLabPly ply(files["mesh.ply"]);
    EXPECT_EQ(ply.images, (std::vector<std::string>{"atlas_0.jpg", "atlas_1.jpg"}));
    EXPECT_EQ(ply.faces[0].texnumber, 1.0);
    EXPECT_EQ(ply.faces[1].texnumber, 0.0);
    EXPECT_EQ(files["atlas_0.jpg"], "not in use");
}

TEST_F(PlyZipTest, TheRemarkIsAComment) {
    auto files = written(&texture_);
    const MeshLabPly ply(files["mesh.ply"]);
    ASSERT_GE(ply.comments.size(), 2U);
    EXPECT_EQ(ply.comments[1], "verdict: good");
}

TEST_F(PlyZipTest, WithoutTextureThereAreNoImagesAndNoCoordinates) {
    auto files = written(nullptr);
    EXPECT_EQ(files.size(), 1U);
    const MeshLabPly ply(files["mesh.ply"]);
    EXPECT_TRUE(ply.images.empty());
    EXPECT_EQ(ply.faces.size(), 3U);
    EXPECT_TRUE(ply.faces[0].texcoord.empty());
}

TEST_F(PlyZipTest, ATextureOfAnotherMeshIsRefused) {
    texture_.uv.pop_back();
    EXPECT_EQ(error_of([&] { written(&texture_); }).code(), ErrorCode::InvalidArgument);
}

}  // namespace
}  // namespace divemesh::io
