#include "worker/io/mosaic_files.hpp"

#include <algorithm>
#include <cstdint>
#include <opencv2/imgcodecs.hpp>

#include "schemas/error.hpp"
#include "worker/base/atomic_file.hpp"
#include "worker/io/raster_reader.hpp"

namespace divemesh::io {
namespace {

using nlohmann::json;

constexpr int kMaxPreviewSide_px = 4096;
constexpr int kRows = 256;  // copied at once
constexpr const char* kColor = "mosaic.tif";
constexpr const char* kHeights = "heights.tif";
constexpr const char* kSigma = "heights_sigma.tif";
constexpr const char* kColorPlace = "mosaic.tfw";
constexpr const char* kHeightsPlace = "heights.tfw";

json to_json(const types::RasterGrid& grid) {
    return {{"width_px", grid.width_px},
            {"height_px", grid.height_px},
            {"pixel_m", grid.pixel_m},
            {"corner_x_m", grid.corner_x_m},
            {"corner_y_m", grid.corner_y_m}};
}

json description(const types::RasterGrid& preview, const types::RasterGrid& whole) {
    json result = to_json(preview);
    result["frame"] = "world (m, z up); columns run along +x, rows along -y, seen from +z";
    result["color_file"] = "mosaic.png";
    result["geotiff"] = to_json(whole);
    result["geotiff"]["color_file"] = kColor;
    result["geotiff"]["heights_file"] = kHeights;
    result["geotiff"]["heights_sigma_file"] = kSigma;
    return result;
}

void write_png(const std::filesystem::path& file, const cv::Mat& image) {
    std::vector<std::uint8_t> png;
    cv::imencode(".png", image, png);
    base::write_file(file, {reinterpret_cast<const char*>(png.data()), png.size()});
}

void write_preview(const std::filesystem::path& folder,
                   const MosaicPreview& preview,
                   const types::RasterGrid& whole) {
    write_png(folder / "mosaic.png", preview.image());
    base::write_file(folder / "mosaic.pgw", world_file(raster_frame(preview.grid(), std::nullopt)));
    base::write_file(folder / "mosaic.json", description(preview.grid(), whole).dump(2) + "\n");
}

void write_world_files(const std::filesystem::path& folder, const RasterFrame& frame) {
    for (const char* name : {kColorPlace, kHeightsPlace})
        base::write_file(folder / name, world_file(frame));
}

void copy_raster(const std::filesystem::path& from,
                 const RasterFrame& frame,
                 const std::filesystem::path& to) {
    RasterReader reader(from);
    GeotiffWriter writer(to, reader.size(), reader.type(), frame, 0);
    for (int row = 0; row < reader.size().height; row += kRows)
        writer.append(reader.rows(row, std::min(kRows, reader.size().height - row)));
    writer.commit();
}

}  // namespace

MosaicWriter::MosaicWriter(const std::filesystem::path& folder,
                           const types::RasterGrid& grid,
                           const std::optional<types::GeographicPosition>& position,
                           int num_threads)
    : folder_(folder),
      grid_(grid),
      frame_(raster_frame(grid, position)),
      color_(folder / kColor, {grid.width_px, grid.height_px}, CV_8UC4, frame_, num_threads),
      heights_(folder / kHeights, {grid.width_px, grid.height_px}, CV_32F, frame_, num_threads),
      sigma_(folder / kSigma, {grid.width_px, grid.height_px}, CV_32F, frame_, num_threads),
      preview_(grid, kMaxPreviewSide_px) {}

void MosaicWriter::append(const cv::Mat& color, const cv::Mat& height_m, const cv::Mat& sigma_m) {
    color_.append(color);
    heights_.append(height_m);
    sigma_.append(sigma_m);
    preview_.append(color);
}

void MosaicWriter::commit() {
    for (GeotiffWriter* writer : {&color_, &heights_, &sigma_}) writer->commit();
    write_world_files(folder_, frame_);
    write_preview(folder_, preview_, grid_);
}

types::RasterGrid mosaic_grid_of(const json& description, const std::filesystem::path& file) try {
    const json& geotiff = description.at("geotiff");
    return {geotiff.at("width_px").get<int>(),
            geotiff.at("height_px").get<int>(),
            geotiff.at("pixel_m").get<double>(),
            geotiff.at("corner_x_m").get<double>(),
            geotiff.at("corner_y_m").get<double>()};
} catch (const json::exception& error) {
    throw Error(ErrorCode::BadData,
                file.string() + ": " + error.what() + ": reconstruct the dive again");
}

std::vector<std::string> copy_mosaic(const std::filesystem::path& folder,
                                     const types::RasterGrid& grid,
                                     const types::GeographicPosition& position,
                                     const std::filesystem::path& out) {
    const RasterFrame frame = raster_frame(grid, position);
    for (const char* name : {kColor, kHeights, kSigma})
        copy_raster(folder / name, frame, out / name);
    write_world_files(out, frame);
    return {kColor, kHeights, kSigma, kColorPlace, kHeightsPlace};
}

}  // namespace divemesh::io
