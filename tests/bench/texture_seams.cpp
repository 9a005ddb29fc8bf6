// Measures the seams of a textured mesh: along each edge whose two triangles show different
// photographs, the step from one side's colour to the other's.
#include <CLI/App.hpp>
#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <map>
#include <nlohmann/json.hpp>
#include <utility>
#include <vector>

#include "worker/io/atlas_images.hpp"
#include "worker/io/mesh_reader.hpp"

namespace divemesh::bench {
namespace {

constexpr int kNumSamples = 3;    // along an edge
constexpr float kSameUv = 1e-6F;  // of an atlas

// What a triangle shows along an edge, from the edge's lower end to its upper one.
struct EdgeSide {
    std::int32_t atlas = 0;
    std::array<Eigen::Vector2f, 2> uv;
};

using Position = std::array<float, 3>;
using MeshEdge = std::pair<Position, Position>;
using EdgeSides = std::map<MeshEdge, std::vector<EdgeSide>>;

// Returns the sides of all edges. A file repeats the vertices of a seam, so edges are told by their
// positions.
EdgeSides sides_of_edges(const io::TexturedMesh& model) {
    EdgeSides sides;
    const auto position = [&](std::uint32_t vertex) {
        const Eigen::Vector3f& p = model.mesh.vertices[vertex];
        return Position{p.x(), p.y(), p.z()};
    };
    for (std::size_t i = 0; i < model.mesh.triangles.size(); ++i) {
        const std::int32_t atlas = model.texture.atlas_of_triangle[i];
        if (atlas == types::TextureMap::kUntextured) continue;
        for (std::size_t k = 0; k < 3; ++k) {
            const auto& triangle = model.mesh.triangles[i];
            const std::size_t next = (k + 1) % 3;
            MeshEdge edge{position(triangle[k]), position(triangle[next])};
            EdgeSide side{atlas, {model.texture.uv[i][k], model.texture.uv[i][next]}};
            if (edge.second < edge.first) {
                std::swap(edge.first, edge.second);
                std::swap(side.uv[0], side.uv[1]);
            }
            sides[edge].push_back(side);
        }
    }
    return sides;
}

bool is_seam(const std::vector<EdgeSide>& sides) {
    if (sides.size() != 2) return false;
    if (sides[0].atlas != sides[1].atlas) return true;
    const auto differs = [&](std::size_t k) {
        return (sides[0].uv[k] - sides[1].uv[k]).cwiseAbs().maxCoeff() > kSameUv;
    };
    return differs(0) || differs(1);
}

double length_m(const MeshEdge& edge) {
    const auto& [a, b] = edge;
    return std::hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]);
}

// Returns the interpolated colour at a place of an image, b g r.
Eigen::Vector3d color_at(const cv::Mat& image, const Eigen::Vector2f& uv) {
    const Eigen::Vector2d size(image.cols, image.rows);
    const Eigen::Vector2d last = size.array() - 1.001;
    const Eigen::Vector2d place =
        (uv.cast<double>().cwiseProduct(size).array() - 0.5).max(0.0).min(last.array());
    const int left = static_cast<int>(place.x());
    const int top = static_cast<int>(place.y());
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    for (int y = top; y < top + 2; ++y)
        for (int x = left; x < left + 2; ++x) {
            const auto& pixel = image.at<cv::Vec3b>(y, x);
            const double weight = (1.0 - std::abs(place.x() - x)) * (1.0 - std::abs(place.y() - y));
            sum += weight * Eigen::Vector3d(pixel[0], pixel[1], pixel[2]);
        }
    return sum;
}

// Steps of colour (mean of the channels, of 255) and the lengths of seam that they stand for, m.
using SeamSteps = std::vector<std::pair<double, double>>;

SeamSteps steps_of(const EdgeSides& edges, io::AtlasImages& atlases) {
    SeamSteps steps;
    for (const auto& [edge, sides] : edges) {
        if (!is_seam(sides)) continue;
        for (int i = 0; i < kNumSamples; ++i) {
            const float part = (static_cast<float>(i) + 0.5F) / kNumSamples;
            std::array<Eigen::Vector3d, 2> colors;
            for (std::size_t k = 0; k < 2; ++k)
                colors[k] = color_at(atlases.image(sides[k].atlas),
                                     (1.0F - part) * sides[k].uv[0] + part * sides[k].uv[1]);
            steps.emplace_back((colors[1] - colors[0]).cwiseAbs().mean(),
                               length_m(edge) / kNumSamples);
        }
    }
    return steps;
}

nlohmann::json judged(SeamSteps steps) {
    std::sort(steps.begin(), steps.end());
    double sum_m = 0.0;
    double sum = 0.0;
    for (const auto& [step, length] : steps) {
        sum_m += length;
        sum += step * length;
    }
    nlohmann::json json = {{"length_m", sum_m}};
    if (steps.empty()) return json;
    json["mean_step"] = sum / sum_m;
    for (const auto& [name, share] : {std::pair{"median_step", 0.5}, std::pair{"p95_step", 0.95}}) {
        double below_m = 0.0;
        for (const auto& [step, length] : steps) {
            json[name] = step;
            below_m += length;
            if (below_m >= share * sum_m) break;
        }
    }
    return json;
}

int run(int argc, char** argv) {
    CLI::App app("Measures the steps of colour (of 255) over the seams of textured meshes.");
    std::vector<std::filesystem::path> models;
    app.add_option("models", models, "mesh.glb of reconstructions")->required();
    CLI11_PARSE(app, argc, argv);

    nlohmann::json json;
    for (const std::filesystem::path& model : models) {
        const io::TexturedMesh mesh = io::read_textured_glb(model);
        io::AtlasImages atlases(mesh.texture);
        json[model.string()] = judged(steps_of(sides_of_edges(mesh), atlases));
    }
    std::printf("%s\n", json.dump(2).c_str());
    return 0;
}

}  // namespace
}  // namespace divemesh::bench

int main(int argc, char** argv) try {
    return divemesh::bench::run(argc, argv);
} catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
}
