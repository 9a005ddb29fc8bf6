#include "worker/report/drawing_page.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "schemas/base64.hpp"
#include "schemas/error.hpp"
#include "worker/base/atomic_file.hpp"
#include "worker/io/raster_reader.hpp"
#include "worker/report/drawing_page_template.hpp"
#include "worker/report/html_template.hpp"

namespace divemesh::report {
namespace {

using nlohmann::json;

constexpr int kMaxHeightSide_px = 1024;
constexpr int kJpegQuality = 88;
static_assert(std::endian::native == std::endian::little);  // as the page reads heights

cv::Mat read_png(const std::filesystem::path& file) {
    cv::Mat image = cv::imread(file.string(), cv::IMREAD_UNCHANGED);
    if (image.empty() || image.type() != CV_8UC4)
        throw Error(ErrorCode::BadData,
                    file.string() + " is not the image that divemesh wrote: reconstruct again");
    return image;
}

std::string image_url(const std::filesystem::path& file) {
    const cv::Mat mosaic = read_png(file);
    cv::Mat image;
    cv::cvtColor(mosaic, image, cv::COLOR_BGRA2BGR);
    cv::Mat unseen;
    cv::extractChannel(mosaic, unseen, 3);
    image.setTo(cv::Scalar(255, 255, 255), unseen == 0);
    std::vector<std::uint8_t> jpeg;
    cv::imencode(".jpg", image, jpeg, {cv::IMWRITE_JPEG_QUALITY, kJpegQuality});
    return "data:image/jpeg;base64," +
           encode_base64({reinterpret_cast<const char*>(jpeg.data()), jpeg.size()});
}

// Heights as the page reads them: steps above the lowest, starting at 1; 0 where there is no
// surface.
struct HeightSteps {
    cv::Mat steps;  // CV_16U
    double lowest_m = 0.0;
    double step_m = 1e-4;
};

HeightSteps height_steps(const cv::Mat& height_m) {
    constexpr double kMaxStepCount = 65534.0;
    HeightSteps heights;
    double highest_m = 0.0;
    const cv::Mat is_known = height_m == height_m;  // not NaN
    if (cv::countNonZero(is_known) > 0)
        cv::minMaxLoc(height_m, &heights.lowest_m, &highest_m, nullptr, nullptr, is_known);
    heights.step_m = std::max(heights.step_m, (highest_m - heights.lowest_m) / kMaxStepCount);
    heights.steps = cv::Mat(height_m.size(), CV_16U, cv::Scalar::all(0));
    for (int row = 0; row < height_m.rows; ++row)
        for (int column = 0; column < height_m.cols; ++column) {
            const auto height = static_cast<double>(height_m.at<float>(row, column));
            if (std::isnan(height)) continue;
            heights.steps.at<std::uint16_t>(row, column) = static_cast<std::uint16_t>(
                1.0 +
                std::min(kMaxStepCount, std::round((height - heights.lowest_m) / heights.step_m)));
        }
    return heights;
}

json height_grid(const std::filesystem::path& file, double width_m) {
    io::RasterReader reader(file, kMaxHeightSide_px);
    const HeightSteps heights = height_steps(reader.rows(0, reader.size().height));
    const cv::Mat& steps = heights.steps;
    return {{"width", steps.cols},
            {"height", steps.rows},
            {"pixel_m", width_m / steps.cols},
            {"lowest_m", heights.lowest_m},
            {"step_m", heights.step_m},
            {"base64",
             encode_base64(
                 {reinterpret_cast<const char*>(steps.data), steps.total() * steps.elemSize()})}};
}

// Returns JSON for a script, where no text may look like the script's end.
std::string for_script(const json& data) {
    std::string text;
    for (const char c : data.dump(-1, ' ', true))
        if (c == '<')
            text += "\\u003c";
        else
            text += c;
    return text;
}

}  // namespace

std::string drawing_page(const io::ReconstructionFolder& model) {
    const json mosaic = model.mosaic();
    json data;
    try {
        const double pixel_m = mosaic.at("pixel_m");
        const int width_px = mosaic.at("width_px");
        data = {{"title", model.metrics().at("dive").at("name")},
                {"width_px", width_px},
                {"height_px", mosaic.at("height_px")},
                {"pixel_m", pixel_m},
                {"corner_x_m", mosaic.at("corner_x_m")},
                {"corner_y_m", mosaic.at("corner_y_m")},
                {"image", image_url(model.path() / "mosaic.png")},
                {"heights", height_grid(model.path() / "heights.tif", pixel_m * width_px)}};
    } catch (const json::exception& error) {
        throw Error(ErrorCode::BadData,
                    (model.path() / "mosaic.json").string() + ": " + error.what());
    }
    return fill_template(drawing_page_template_html(), {{"data", for_script(data)}});
}

void write_drawing_page(const io::ReconstructionFolder& model, const std::filesystem::path& path) {
    base::write_file(path, drawing_page(model));
}

}  // namespace divemesh::report
