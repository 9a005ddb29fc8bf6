// Compares the textured mesh of a reconstruction with its photographs: mesh.glb is drawn as each
// keyframe saw it, and the contrast of fine detail in it is related to that of the photograph.
//
//     divemesh_texture_sharpness MODEL     # reconstructed with --set exports=colmap

#include <algorithm>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "schemas/error.hpp"
#include "tests/bench/draw_mesh.hpp"
#include "worker/io/mesh_reader.hpp"
#include "worker/io/reconstruction_folder.hpp"
#include "worker/stats/quantile.hpp"

namespace divemesh::bench {
namespace {

namespace fs = std::filesystem;

constexpr int kTile_px = 32;
constexpr double kFine_px = 0.8;      // standard deviations of the blurs between which detail lies:
constexpr double kCoarse_px = 2.0;    // periods of 3 to 12 px
constexpr double kMinContrast = 3.0;  // of 255; below it is noise

cv::Mat detail_of(const cv::Mat& image) {
    cv::Mat grey;
    cv::cvtColor(image, grey, cv::COLOR_BGR2GRAY);
    grey.convertTo(grey, CV_32F);
    cv::Mat fine;
    cv::Mat coarse;
    cv::GaussianBlur(grey, fine, {}, kFine_px);
    cv::GaussianBlur(grey, coarse, {}, kCoarse_px);
    return fine - coarse;
}

double contrast(const cv::Mat& detail) {
    cv::Scalar mean;
    cv::Scalar deviation;
    cv::meanStdDev(detail, mean, deviation);
    return deviation[0];
}

// How a texture compares with photographs, tile by tile.
struct TileComparison {
    std::vector<double> ratios;        // of contrast
    std::vector<double> correlations;  // of detail
};

void compare(const cv::Mat& drawn, const cv::Mat& photograph, TileComparison& tiles) {
    cv::Mat no_mesh;
    cv::inRange(drawn, cv::Scalar(255, 0, 255), cv::Scalar(255, 0, 255), no_mesh);
    const cv::Mat details[] = {detail_of(drawn), detail_of(photograph)};
    for (int y = kTile_px; y + 2 * kTile_px <= drawn.rows; y += kTile_px)
        for (int x = kTile_px; x + 2 * kTile_px <= drawn.cols; x += kTile_px) {
            const cv::Rect tile(x, y, kTile_px, kTile_px);
            if (cv::countNonZero(no_mesh(tile)) > 0) continue;
            const double shown = contrast(details[0](tile));
            const double seen = contrast(details[1](tile));
            if (seen < kMinContrast) continue;
            tiles.ratios.push_back(shown / seen);
            const double covariance =
                details[0](tile).dot(details[1](tile)) / (kTile_px * kTile_px) -
                cv::mean(details[0](tile))[0] * cv::mean(details[1](tile))[0];
            tiles.correlations.push_back(shown > 0.0 ? covariance / (shown * seen) : 0.0);
        }
}

nlohmann::json quantiles(std::vector<double> values) {
    std::sort(values.begin(), values.end());
    const auto at = [&](double share) { return stats::quantile_of_sorted(values, share); };
    return {{"p10", at(0.1)}, {"median", at(0.5)}, {"p90", at(0.9)}};
}

nlohmann::json judged(const fs::path& model) {
    const io::ReconstructionFolder reconstruction(model);
    const io::TexturedMesh shown = io::read_textured_glb(model / "mesh.glb");
    const io::KeyframeCamera camera = reconstruction.keyframe_camera();
    const cv::Size size(static_cast<int>(camera.size_px.x()), static_cast<int>(camera.size_px.y()));
    TileComparison tiles;
    for (const io::KeyframePose& keyframe : reconstruction.keyframes()) {
        char name[40];
        std::snprintf(name, sizeof name, "%06d.jpg", keyframe.frame_index);
        const fs::path file = model / "colmap/images" / name;
        const cv::Mat photograph = cv::imread(file.string());
        if (photograph.size() != size)
            throw Error(ErrorCode::NotFound,
                        file.string() + " is no whole image: reconstruct with exports=colmap");
        compare(draw_mesh(shown, {keyframe.T_world_cam, camera.focal_px, size, camera.center_px}),
                photograph,
                tiles);
    }
    nlohmann::json json = {{"num_tiles", tiles.ratios.size()}};
    if (tiles.ratios.empty()) return json;
    json["contrast_ratio"] = quantiles(tiles.ratios);
    json["correlation"] = quantiles(tiles.correlations);
    return json;
}

}  // namespace
}  // namespace divemesh::bench

int main(int argc, char** argv) try {
    if (argc != 2) {
        std::fprintf(stderr, "divemesh_texture_sharpness MODEL\n");
        return 2;
    }
    std::printf("%s\n", divemesh::bench::judged(argv[1]).dump(2).c_str());
    return 0;
} catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
}
