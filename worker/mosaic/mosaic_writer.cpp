#include <algorithm>
#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>

#include "worker/base/atomic_file.hpp"
#include "worker/mosaic/mosaic.hpp"

namespace divemesh::mosaic {
namespace {

// Heights as steps above the lowest, starting at 1; 0 where there is no surface.
struct HeightImage {
    cv::Mat steps;  // CV_16U
    double lowest_m = 0.0;
    double step_m = 1e-4;
};

HeightImage height_image(const cv::Mat& height_m) {
    constexpr double kMaxStepCount = 65534.0;
    HeightImage image;
    double lowest = 0.0;
    double highest = 0.0;
    cv::Mat is_known;  // not NaN
    cv::compare(height_m, height_m, is_known, cv::CMP_EQ);
    if (cv::countNonZero(is_known) > 0)
        cv::minMaxLoc(height_m, &lowest, &highest, nullptr, nullptr, is_known);
    image.lowest_m = lowest;
    image.step_m = std::max(image.step_m, (highest - lowest) / kMaxStepCount);
    image.steps = cv::Mat(height_m.size(), CV_16U, cv::Scalar::all(0));
    for (int row = 0; row < height_m.rows; ++row)
        for (int column = 0; column < height_m.cols; ++column) {
            const auto height = static_cast<double>(height_m.at<float>(row, column));
            if (std::isnan(height)) continue;
            image.steps.at<std::uint16_t>(row, column) = static_cast<std::uint16_t>(
                1.0 + std::min(kMaxStepCount, std::round((height - lowest) / image.step_m)));
        }
    return image;
}

void write_png(const std::filesystem::path& file, const cv::Mat& image) {
    std::vector<std::uint8_t> png;
    cv::imencode(".png", image, png);
    base::write_file(file, {reinterpret_cast<const char*>(png.data()), png.size()});
}

// Returns the six lines of an ESRI world file: the world's (x, y) of a pixel's centre is (A column
// + B row + C, D column + E row + F), in the order A D B E C F.
std::string world_file(const Mosaic& mosaic) {
    std::string text;
    for (const double value : {mosaic.pixel_m,
                               0.0,
                               0.0,
                               -mosaic.pixel_m,
                               mosaic.corner_x_m + 0.5 * mosaic.pixel_m,
                               mosaic.corner_y_m - 0.5 * mosaic.pixel_m}) {
        char line[40];
        std::snprintf(line, sizeof line, "%.12g\n", value);
        text += line;
    }
    return text;
}

}  // namespace

void write_mosaic(const std::filesystem::path& folder, const Mosaic& mosaic) {
    const HeightImage heights = height_image(mosaic.height_m);
    const nlohmann::json description = {
        {"frame", "world (m, z up); columns run along +x, rows along -y, seen from +z"},
        {"width_px", mosaic.color.cols},
        {"height_px", mosaic.color.rows},
        {"pixel_m", mosaic.pixel_m},
        {"corner_x_m", mosaic.corner_x_m},
        {"corner_y_m", mosaic.corner_y_m},
        {"color_file", "mosaic.png"},
        {"elevation",
         {{"file", "mosaic_height.png"},
          {"meaning", "z_m = lowest_m + (value - 1) * step_m; value 0: no surface"},
          {"lowest_m", heights.lowest_m},
          {"step_m", heights.step_m}}}};
    write_png(folder / "mosaic.png", mosaic.color);
    write_png(folder / "mosaic_height.png", heights.steps);
    base::write_file(folder / "mosaic.pgw", world_file(mosaic));
    base::write_file(folder / "mosaic_height.pgw", world_file(mosaic));
    base::write_file(folder / "mosaic.json", description.dump(2) + "\n");
}

}  // namespace divemesh::mosaic
