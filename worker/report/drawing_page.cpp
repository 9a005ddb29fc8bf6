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
#include "worker/report/drawing_page_template.hpp"
#include "worker/report/html_template.hpp"

namespace divemesh::report {
namespace {

using nlohmann::json;

constexpr double kMaxImageSide_px = 4096.0;
constexpr double kMaxHeightSide_px = 1024.0;
constexpr int kJpegQuality = 88;
static_assert(std::endian::native == std::endian::little);  // as the page reads heights

cv::Mat read_png(const std::filesystem::path& file, int flags, int type) {
    cv::Mat image = cv::imread(file.string(), flags);
    if (image.empty() || image.type() != type)
        throw Error(ErrorCode::BadData,
                    file.string() + " is not the image that divemesh wrote: reconstruct again");
    return image;
}

cv::Mat no_larger(const cv::Mat& image, double max_image_side_px, int interpolation) {
    const double factor = max_image_side_px / std::max(image.cols, image.rows);
    if (factor >= 1.0) return image;
    cv::Mat smaller;
    cv::resize(image, smaller, {}, factor, factor, interpolation);
    return smaller;
}

std::string image_url(const std::filesystem::path& file) {
    const cv::Mat mosaic =
        no_larger(read_png(file, cv::IMREAD_UNCHANGED, CV_8UC4), kMaxImageSide_px, cv::INTER_AREA);
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

// Takes nodes without averaging, because 0 means that there is no surface.
json height_grid(const std::filesystem::path& file, const json& elevation, double width_m) {
    const cv::Mat steps = no_larger(
        read_png(file, cv::IMREAD_UNCHANGED, CV_16UC1), kMaxHeightSide_px, cv::INTER_NEAREST);
    return {{"width", steps.cols},
            {"height", steps.rows},
            {"pixel_m", width_m / steps.cols},
            {"lowest_m", elevation.at("lowest_m")},
            {"step_m", elevation.at("step_m")},
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
        data = {
            {"title", model.metrics().at("dive").at("name")},
            {"width_px", width_px},
            {"height_px", mosaic.at("height_px")},
            {"pixel_m", pixel_m},
            {"corner_x_m", mosaic.at("corner_x_m")},
            {"corner_y_m", mosaic.at("corner_y_m")},
            {"image", image_url(model.path() / "mosaic.png")},
            {"heights",
             height_grid(
                 model.path() / "mosaic_height.png", mosaic.at("elevation"), pixel_m * width_px)}};
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
