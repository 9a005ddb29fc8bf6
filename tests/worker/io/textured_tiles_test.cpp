#include <algorithm>
#include <opencv2/imgproc.hpp>
#include <set>

#include "tests/worker/io/tiles_of_waves.hpp"
#include "worker/io/jpeg.hpp"

namespace divemesh::io {
namespace {

using nlohmann::json;

// The charts are squares of 16 cells a side, in two atlases, each chart with a border of its own
// colours and magenta beyond, which no tile may show.
constexpr int kCellsOfChart = 16;
constexpr int kTexelsOfCell = 8;
constexpr int kChart_px = kCellsOfChart * kTexelsOfCell;
constexpr int kBorder_px = 4;
constexpr int kPitch_px = kChart_px + 2 * kBorder_px + 8;
constexpr double kCell_m = kWaves_m / kNumWaveCells;
constexpr double kTexel_m = kCell_m / kTexelsOfCell;
constexpr double kCheck_m = 8 * kCell_m;
const cv::Vec3d kDark(60, 60, 60);
const cv::Vec3d kLight(200, 200, 200);
const cv::Vec3d kMagenta(255, 0, 255);

cv::Vec3d checker(double x, double y) {
    const auto number = [](double value) { return static_cast<int>(std::floor(value / kCheck_m)); };
    return (number(x) + number(y)) % 2 == 0 ? kDark : kLight;
}

// Returns the distance from the next edge between two checks.
double from_edge_m(double x, double y) {
    const auto distance = [](double value) {
        return std::abs(value - kCheck_m * std::round(value / kCheck_m));
    };
    return std::min(distance(x), distance(y));
}

// The waves with a checker. `num_cells` is the side that has a texture, a multiple of
// kCellsOfChart; the other triangles have the colours of the vertices.
TexturedMesh checkered_waves(int num_cells) {
    TexturedMesh waved{waves(), {}};
    constexpr int kCharts = kNumWaveCells / kCellsOfChart;
    std::vector<cv::Mat> atlases;
    for (int atlas = 0; atlas < 2; ++atlas)
        atlases.emplace_back(
            kCharts * kPitch_px, kCharts / 2 * kPitch_px, CV_8UC3, cv::Scalar(255, 0, 255));
    for (int row = 0; row < kCharts; ++row)
        for (int column = 0; column < kCharts; ++column)
            for (int v = -kBorder_px; v < kChart_px + kBorder_px; ++v)
                for (int u = -kBorder_px; u < kChart_px + kBorder_px; ++u) {
                    const double x = (column * kChart_px + u + 0.5) * kTexel_m;
                    const double y = (row * kChart_px + v + 0.5) * kTexel_m;
                    atlases[column % 2].at<cv::Vec3b>(row * kPitch_px + kBorder_px + v,
                                                      column / 2 * kPitch_px + kBorder_px + u) =
                        checker(x, y);
                }
    for (std::size_t i = 0; i < waved.mesh.triangles.size(); ++i) {
        const int cell = static_cast<int>(i / 2);
        const int row = cell / kNumWaveCells / kCellsOfChart;
        const int column = cell % kNumWaveCells / kCellsOfChart;
        const bool is_textured = std::max(row, column) * kCellsOfChart < num_cells;
        waved.texture.atlas_of_triangle.push_back(is_textured ? column % 2
                                                              : types::TextureMap::kUntextured);
        auto& uv = waved.texture.uv.emplace_back();
        for (std::size_t k = 0; k < 3; ++k) {
            const Eigen::Vector3f& p = waved.mesh.vertices[waved.mesh.triangles[i][k]];
            const double u = column / 2 * kPitch_px + kBorder_px +
                             static_cast<double>(p.x()) / kTexel_m - column * kChart_px;
            const double v = row * kPitch_px + kBorder_px + static_cast<double>(p.y()) / kTexel_m -
                             row * kChart_px;
            uv[k] = is_textured
                        ? Eigen::Vector2d(u / atlases[0].cols, v / atlases[0].rows).cast<float>()
                        : Eigen::Vector2f(0.0F, 0.0F);
        }
    }
    for (const cv::Mat& atlas : atlases) waved.texture.jpegs.push_back(encode_jpeg(atlas));
    return waved;
}

// Returns a bilinear sample, as a viewer shows it.
cv::Vec3d sample(const cv::Mat& atlas, const Eigen::Vector2f& uv) {
    cv::Mat patch;
    cv::getRectSubPix(atlas,
                      cv::Size(1, 1),
                      cv::Point2f(uv.x() * static_cast<float>(atlas.cols) - 0.5F,
                                  uv.y() * static_cast<float>(atlas.rows) - 0.5F),
                      patch);
    return patch.at<cv::Vec3b>(0, 0);
}

// Calls use(place, color) for points of the textured triangles: corners, edges and inside.
template <typename Use>
void for_each_sample(const TexturedMesh& tile, const Use& use) {
    std::vector<cv::Mat> atlases;
    for (const std::string& jpeg : tile.texture.jpegs) atlases.push_back(decode_jpeg(jpeg));
    constexpr int kSteps = 6;
    for (std::size_t i = 0; i < tile.mesh.triangles.size(); ++i) {
        const std::int32_t atlas = tile.texture.atlas_of_triangle[i];
        if (atlas == types::TextureMap::kUntextured) continue;
        for (int a = 0; a <= kSteps; ++a)
            for (int b = 0; a + b <= kSteps; ++b) {
                const Eigen::Vector3f weights =
                    Eigen::Vector3f(static_cast<float>(a),
                                    static_cast<float>(b),
                                    static_cast<float>(kSteps - a - b)) /
                    static_cast<float>(kSteps);
                Eigen::Vector3f place = Eigen::Vector3f::Zero();
                Eigen::Vector2f uv = Eigen::Vector2f::Zero();
                for (std::size_t k = 0; k < 3; ++k) {
                    const float weight = weights[static_cast<Eigen::Index>(k)];
                    place += weight * tile.mesh.vertices[tile.mesh.triangles[i][k]];
                    uv += weight * tile.texture.uv[i][k];
                }
                use(place, sample(atlases[atlas], uv));
            }
    }
}

double distance(const cv::Vec3d& a, const cv::Vec3d& b) { return cv::norm(a, b, cv::NORM_INF); }

class TexturedTilesTest : public TilesTest {
protected:
    TexturedMesh textured_mesh_of(const json& tile) const {
        return read_textured_glb(file("tiles/" + tile["content"]["uri"].get<std::string>()));
    }
    json write_checkered(int num_cells, const TilesDescription& description) const {
        const TexturedMesh waved = checkered_waves(num_cells);
        write_tiles(file("tiles"), waved.mesh, &waved.texture, description);
        return tileset()["root"];
    }
    static std::int64_t num_texels(const TexturedMesh& tile) {
        std::int64_t sum = 0;
        for (const std::string& jpeg : tile.texture.jpegs) sum += jpeg_size(jpeg)->area();
        return sum;
    }
};

TEST_F(TexturedTilesTest, EveryTileShowsTheColoursOfTheSurfaceAndNoneOfAnotherChart) {
    const json root = write_checkered(
        kNumWaveCells, {.position = std::nullopt, .text = "t", .max_triangles = 700});
    int num_tiles = 0;
    for_each(root, [&](const json& tile) {
        ++num_tiles;
        const double texel_m = tile["extras"]["texel_m"];
        // JPEG, and where triangles were simplified the picture moves along with them.
        const double reach_m =
            1.5 * texel_m + 2.0 * tile["extras"]["simplification_m"].get<double>();
        double worst = 0.0;
        double bleeding = 0.0;
        int num_compared = 0;
        for_each_sample(textured_mesh_of(tile),
                        [&](const Eigen::Vector3f& p, const cv::Vec3d& color) {
                            const auto x = static_cast<double>(p.x());
                            const auto y = static_cast<double>(p.y());
                            // Grey has as much green as the others.
                            bleeding = std::max(bleeding, 0.5 * (color[0] + color[2]) - color[1]);
                            if (from_edge_m(x, y) < reach_m) return;
                            worst = std::max(worst, distance(color, checker(x, y)));
                            ++num_compared;
                        });
        EXPECT_GT(num_compared, 100);
        EXPECT_LT(worst, 24.0) << tile["content"]["uri"];
        EXPECT_LT(bleeding, 24.0) << tile["content"]["uri"];
    });
    EXPECT_EQ(num_tiles, 21);
}

TEST_F(TexturedTilesTest, TexelsOfLeavesAreThoseOfTheAtlasesAndEachLevelAboveHasAQuarter) {
    const json root = write_checkered(
        kNumWaveCells, {.position = std::nullopt, .text = "t", .max_triangles = 700});
    const double stretch = 1.05;  // the waves are steeper than their plan
    for_each(root, [&](const json& tile) {
        const std::string name = tile["content"]["uri"];
        const int level = name == "root.glb" ? 2 : name.size() == 5 ? 1 : 0;
        const double texel_m = tile["extras"]["texel_m"];
        EXPECT_GT(texel_m, 0.99 * kTexel_m * (1 << level)) << name;
        EXPECT_LT(texel_m, stretch * kTexel_m * (1 << level)) << name;
        if (level > 0) {
            EXPECT_GE(tile["geometricError"].get<double>(), 16.0 * texel_m);
        } else {
            EXPECT_EQ(tile["geometricError"], 0.0);
        }
        for (const json& child : tile.value("children", json::array()))
            EXPECT_LT(child["geometricError"], tile["geometricError"]);
        const int side_px = (kChart_px >> level) + 2 + 2 * kBorder_px;
        EXPECT_LE(num_texels(textured_mesh_of(tile)), (1 << (2 * level)) * side_px * side_px)
            << name;
    });
}

TEST_F(TexturedTilesTest, LeavesWithMoreTexelsThanATileMayHaveAreCut) {
    constexpr std::int64_t kMaxTexels = 150 * 150;
    const json root = write_checkered(
        kNumWaveCells, {.position = std::nullopt, .text = "t", .max_texels = kMaxTexels});
    int num_leaves = 0;
    for_each(root, [&](const json& tile) {
        EXPECT_LE(num_texels(textured_mesh_of(tile)), 1.1 * kMaxTexels);  // gaps between charts
        if (!tile.contains("children")) ++num_leaves;
    });
    EXPECT_EQ(num_leaves, 16);
}

TEST_F(TexturedTilesTest, SeamsAreClosedInEveryDetail) {
    const json root = write_checkered(
        kNumWaveCells, {.position = std::nullopt, .text = "t", .max_triangles = 700});
    const types::Mesh coarse = textured_mesh_of(root["children"][0]).mesh;
    EXPECT_LT(coarse.triangles.size(), 2U * kNumWaveCells * kNumWaveCells / 4);
    std::map<std::pair<std::uint32_t, std::uint32_t>, int> edges;
    for (const auto& triangle : coarse.triangles)
        for (std::size_t i = 0; i < 3; ++i)
            ++edges[std::minmax(triangle[i], triangle[(i + 1) % 3])];
    const auto num_border = std::count_if(
        edges.begin(), edges.end(), [](const auto& entry) { return entry.second == 1; });
    EXPECT_EQ(num_border, 4 * kNumWaveCells / 2);
}

TEST_F(TexturedTilesTest, TrianglesWithoutTextureKeepTheColoursOfTheirVertices) {
    const json root = write_checkered(
        kNumWaveCells / 2, {.position = std::nullopt, .text = "t", .max_triangles = 700});
    std::size_t num_untextured = 0;
    for_each(root, [&](const json& tile) {
        if (tile.contains("children")) return;
        const TexturedMesh leaf = textured_mesh_of(tile);
        for (std::size_t i = 0; i < leaf.mesh.triangles.size(); ++i) {
            if (leaf.texture.atlas_of_triangle[i] != types::TextureMap::kUntextured) continue;
            ++num_untextured;
            EXPECT_EQ(leaf.mesh.colors[leaf.mesh.triangles[i][0]], (types::Color{10, 200, 30}));
        }
    });
    EXPECT_EQ(num_untextured, 2U * kNumWaveCells * kNumWaveCells * 3 / 4);
}

TEST_F(TexturedTilesTest, TheSameMeshGivesTheSameBytes) {
    const TilesDescription description{.position = std::nullopt, .text = "t", .max_triangles = 700};
    write_checkered(kNumWaveCells, description);
    const std::string once = read(file("tiles/root.glb"));
    write_checkered(kNumWaveCells, description);
    EXPECT_TRUE(read(file("tiles/root.glb")) == once);
}

TEST_F(TexturedTilesTest, AnAtlasThatIsNoImageIsBadData) {
    TexturedMesh waved = checkered_waves(kNumWaveCells);
    const std::string jpeg = waved.texture.jpegs[1];
    const auto refusal = [&](const std::string& bytes) {
        waved.texture.jpegs[1] = bytes;
        return error_of([&] {
            write_tiles(
                file("tiles"), waved.mesh, &waved.texture, {.position = std::nullopt, .text = "t"});
        });
    };
    std::string huge = jpeg;
    const std::size_t frame = huge.find("\xff\xc0");
    ASSERT_NE(frame, std::string::npos);
    huge[frame + 7] = '\x7f';  // the width's upper byte
    for (const std::string& bytes : {std::string(), std::string("png"), jpeg.substr(0, 100), huge})
        EXPECT_EQ(refusal(bytes).code(), ErrorCode::BadData);
    EXPECT_NE(std::string(refusal(huge).what()).find("8192"), std::string::npos);
}

TEST(JpegSizeTest, IsThatOfTheImage) {
    const cv::Mat image(17, 300, CV_8UC3, cv::Scalar(1, 2, 3));
    EXPECT_EQ(jpeg_size(encode_jpeg(image)), cv::Size(300, 17));
    EXPECT_EQ(decode_jpeg(encode_jpeg(image)).size(), image.size());
    EXPECT_TRUE(decode_jpeg("no image").empty());
}

}  // namespace
}  // namespace divemesh::io
