// Draws what a reconstruction looks like, to be looked at: its mesh.glb from above, from two sides
// and from near, its mosaic and its heights.
//
//     divemesh_pictures RESULT OUT

#include <algorithm>
#include <filesystem>
#include <iostream>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <string>
#include <vector>

#include "schemas/error.hpp"
#include "tests/bench/draw_mesh.hpp"
#include "worker/io/mesh_reader.hpp"
#include "worker/io/raster_reader.hpp"
#include "worker/io/reconstruction_folder.hpp"
#include "worker/stats/quantile.hpp"

namespace divemesh::bench {
namespace {

namespace fs = std::filesystem;

constexpr int kMaxSide_px = 1600;
constexpr double kOutermost = 0.02;  // share of the heights at either end that saturate

void save(const fs::path& file, const cv::Mat& image) {
    if (!cv::imwrite(file.string(), image))
        throw Error(ErrorCode::Unavailable, "cannot write " + file.string());
    std::cout << file.string() << '\n';
}

cv::Mat read_image(const fs::path& file) {
    const cv::Mat image = cv::imread(file.string(), cv::IMREAD_UNCHANGED);
    if (image.empty()) throw Error(ErrorCode::BadData, "cannot read the image " + file.string());
    return image;
}

cv::Mat reduced(const cv::Mat& image) {
    const double scale = static_cast<double>(kMaxSide_px) / std::max(image.cols, image.rows);
    if (scale >= 1.0) return image;
    cv::Mat result;
    cv::resize(image, result, {}, scale, scale, cv::INTER_AREA);
    return result;
}

void draw_meshes(const fs::path& result, const fs::path& out) {
    const io::TexturedMesh shown = io::read_textured_glb(result / "mesh.glb");
    const Eigen::Vector3d oblique = Eigen::Vector3d(0.0, -1.0, 1.0).normalized();
    const Eigen::Vector3d end = Eigen::Vector3d(1.0, 0.0, 0.5).normalized();
    save(out / "mesh_above.png",
         draw_mesh(shown, whole_view(shown.mesh, Eigen::Vector3d::UnitZ())));
    save(out / "mesh_oblique.png", draw_mesh(shown, whole_view(shown.mesh, oblique)));
    save(out / "mesh_end.png", draw_mesh(shown, whole_view(shown.mesh, end)));
    save(out / "mesh_close.png", draw_mesh(shown, close_view(shown.mesh, oblique)));
}

// Returns heights from low, blue, to high, red; black where they are NaN. Some must not be.
cv::Mat colored_heights(cv::Mat heights) {
    const cv::Mat is_known = heights == heights;
    std::vector<double> sorted;
    for (int row = 0; row < heights.rows; ++row)
        for (int column = 0; column < heights.cols; ++column)
            if (is_known.at<std::uint8_t>(row, column) != 0)
                sorted.push_back(heights.at<float>(row, column));
    std::sort(sorted.begin(), sorted.end());
    const double low = stats::quantile_of_sorted(sorted, kOutermost);
    const double high = std::max(low + 1e-6, stats::quantile_of_sorted(sorted, 1.0 - kOutermost));
    heights.setTo(low, ~is_known);
    cv::Mat grey;
    heights.convertTo(grey, CV_8U, 255.0 / (high - low), -255.0 * low / (high - low));
    cv::Mat colored;
    cv::applyColorMap(grey, colored, cv::COLORMAP_TURBO);
    colored.setTo(cv::Scalar::all(0), ~is_known);
    return colored;
}

void draw_rasters(const fs::path& result, const fs::path& out) {
    const nlohmann::json mosaic = io::ReconstructionFolder(result).mosaic();
    save(out / "mosaic.png",
         reduced(read_image(result / mosaic.at("color_file").get<std::string>())));
    const auto heights = mosaic.at("geotiff").at("heights_file").get<std::string>();
    io::RasterReader reader(result / heights, kMaxSide_px);
    save(out / "heights.png", colored_heights(reader.rows(0, reader.size().height)));
}

}  // namespace
}  // namespace divemesh::bench

int main(int argc, char** argv) try {
    if (argc != 3) {
        std::cerr << "divemesh_pictures RESULT OUT\n";
        return 2;
    }
    std::filesystem::create_directories(argv[2]);
    divemesh::bench::draw_meshes(argv[1], argv[2]);
    divemesh::bench::draw_rasters(argv[1], argv[2]);
    return 0;
} catch (const std::exception& error) {
    std::cerr << error.what() << '\n';
    return 1;
}
