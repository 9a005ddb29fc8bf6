#include "worker/io/exports.hpp"

#include <algorithm>

#include "schemas/enum_text.hpp"
#include "schemas/error.hpp"
#include "worker/base/atomic_file.hpp"
#include "worker/io/certificate.hpp"
#include "worker/io/colmap_writer.hpp"
#include "worker/io/e57_writer.hpp"
#include "worker/io/geographic_frame.hpp"
#include "worker/io/las_writer.hpp"
#include "worker/io/mcap_writer.hpp"
#include "worker/io/mesh_reader.hpp"
#include "worker/io/mosaic_files.hpp"
#include "worker/io/nerfstudio_writer.hpp"
#include "worker/io/obj_writer.hpp"
#include "worker/io/ply_zip.hpp"
#include "worker/io/thin_points.hpp"
#include "worker/io/tiles_writer.hpp"
#include "worker/io/trajectory_file.hpp"

namespace divemesh::io {
namespace {

constexpr EnumText<ExportFormat> kTexts[] = {
    {ExportFormat::Kitti, "kitti"},
    {ExportFormat::Euroc, "euroc"},
    {ExportFormat::Obj, "obj"},
    {ExportFormat::Ply, "ply"},
    {ExportFormat::Geotiff, "geotiff"},
    {ExportFormat::Colmap, "colmap"},
    {ExportFormat::Nerfstudio, "nerfstudio"},
    {ExportFormat::Las, "las"},
    {ExportFormat::Laz, "laz"},
    {ExportFormat::E57, "e57"},
    {ExportFormat::Tiles, "3dtiles"},
    {ExportFormat::Mcap, "mcap"},
};

// Throws Error{NotFound} if the reconstruction was made without a mosaic.
void require_mosaic(const ReconstructionFolder& reconstruction) {
    for (const char* name : {"mosaic.json", "mosaic.tif", "heights.tif", "heights_sigma.tif"})
        if (!std::filesystem::exists(reconstruction.path() / name))
            throw Error(ErrorCode::NotFound,
                        std::string("no ") + name + " in " + reconstruction.path().string() +
                            ", so there is no mosaic to place: copy the whole reconstruction, or "
                            "reconstruct the dive with a surface and without --no-texture");
}

std::vector<std::string> export_geotiff(const ReconstructionFolder& reconstruction,
                                        const std::optional<types::GeographicPosition>& position,
                                        const std::filesystem::path& out) {
    if (!position)
        throw Error(ErrorCode::InvalidArgument,
                    "the position of the dive is not known, so a GeoTIFF cannot be written: write "
                    "position {latitude_deg, longitude_deg, x_azimuth_deg} into its dive.json, or "
                    "give --latitude and --longitude");
    require_mosaic(reconstruction);
    const types::RasterGrid grid =
        mosaic_grid_of(reconstruction.mosaic(), reconstruction.path() / "mosaic.json");
    return copy_mosaic(reconstruction.path(), grid, *position, out);
}

void write_certificate(const std::filesystem::path& folder, const nlohmann::json& certificate) {
    base::write_file(folder / "certificate.json", certificate.dump(2) + "\n");
}

// Throws Error{NotFound} if the reconstruction lacks a file of its surface.
void require_surface(const ReconstructionFolder& reconstruction, const char* file) {
    if (!std::filesystem::exists(reconstruction.path() / file))
        throw Error(ErrorCode::NotFound,
                    std::string("no ") + file + " in " + reconstruction.path().string() +
                        ": copy the whole reconstruction, or reconstruct the dive with a surface");
}

// Returns what trainers of splats begin with; points without a colour are grey.
types::Mesh thinned_cloud(const ReconstructionFolder& reconstruction) {
    constexpr std::size_t kMaxPoints = 100'000;
    constexpr types::Color kGrey = {128, 128, 128};
    require_surface(reconstruction, "cloud.ply");
    const types::Mesh cloud = reconstruction.cloud();
    types::Mesh thinned;
    for (const std::size_t i : thin_points(cloud.vertices, kMaxPoints)) {
        thinned.vertices.push_back(cloud.vertices[i]);
        thinned.colors.push_back(cloud.colors.empty() ? kGrey : cloud.colors[i]);
    }
    return thinned;
}

// Writes the folder of a program that goes on from poses, images and points; `write` makes its
// model in `model`.
template <typename WriteModel>
std::vector<std::string> export_posed_images(const ReconstructionFolder& reconstruction,
                                             const nlohmann::json& certificate,
                                             const WholeImage& whole_image,
                                             const std::filesystem::path& folder,
                                             const std::filesystem::path& model,
                                             const WriteModel& write) {
    const PosedImages images = read_posed_images(reconstruction, whole_image);
    write(model, images, thinned_cloud(reconstruction), certificate_line(certificate));
    write_images(images, folder / "images");
    write_certificate(folder, certificate);
    return {folder.filename().string()};
}

// Returns the textured mesh of mesh.glb, or without a texture the whole mesh of mesh.ply.
TexturedMesh shown_mesh(const ReconstructionFolder& reconstruction) {
    const std::filesystem::path glb = reconstruction.path() / "mesh.glb";
    if (std::filesystem::exists(glb)) {
        TexturedMesh shown = read_textured_glb(glb);
        if (!shown.texture.jpegs.empty()) return shown;
    }
    require_surface(reconstruction, "mesh.ply");
    return {reconstruction.mesh(), {}};
}

const StoredTexture* texture_or_null(const TexturedMesh& shown) {
    return shown.texture.jpegs.empty() ? nullptr : &shown.texture;
}

std::vector<std::string> export_obj(const ReconstructionFolder& reconstruction,
                                    const std::string& remark,
                                    const std::filesystem::path& out) {
    const TexturedMesh shown = shown_mesh(reconstruction);
    write_obj_zip(out / "mesh_obj.zip", shown.mesh, texture_or_null(shown), remark);
    return {"mesh_obj.zip"};
}

std::vector<std::string> export_ply(const ReconstructionFolder& reconstruction,
                                    const std::string& remark,
                                    const std::filesystem::path& out) {
    const TexturedMesh shown = shown_mesh(reconstruction);
    write_ply_zip(out / "mesh_ply.zip", shown.mesh, texture_or_null(shown), remark);
    return {"mesh_ply.zip"};
}

std::string description_text(const nlohmann::json& certificate,
                             const std::optional<types::GeographicPosition>& position) {
    std::string text = certificate_line(certificate);
    if (position && !position->x_azimuth_deg) text += "; NORTH NOT KNOWN: y axis taken for it";
    return text;
}

std::vector<std::string> export_las(const ReconstructionFolder& reconstruction,
                                    LasStorage storage,
                                    const std::optional<types::GeographicPosition>& position,
                                    const nlohmann::json& certificate,
                                    const std::filesystem::path& out) {
    require_surface(reconstruction, "mesh.ply");
    LasDescription description{
        .utm = std::nullopt, .text = description_text(certificate, position), .date = std::nullopt};
    if (position) description.utm = utm_frame(*position);
    if (const auto begin = recording_begin(reconstruction.metrics()))
        description.date = std::chrono::floor<std::chrono::days>(*begin);
    const std::string name = storage == LasStorage::Laszip ? "surface.laz" : "surface.las";
    write_las(out / name, reconstruction.mesh(), description, storage);
    return {name};
}

// Removes the tiles of an earlier export, which may have had more of them.
void remove_tiles(const std::filesystem::path& folder) {
    if (!std::filesystem::is_directory(folder)) return;
    std::vector<std::filesystem::path> tiles;
    for (const auto& file : std::filesystem::directory_iterator(folder))
        if (file.path().extension() == ".glb") tiles.push_back(file.path());
    for (const std::filesystem::path& tile : tiles) std::filesystem::remove(tile);
}

std::vector<std::string> export_tiles(const ReconstructionFolder& reconstruction,
                                      const std::optional<types::GeographicPosition>& position,
                                      const nlohmann::json& certificate,
                                      const std::filesystem::path& out) {
    const TexturedMesh shown = shown_mesh(reconstruction);
    remove_tiles(out / "tiles");
    write_tiles(out / "tiles",
                shown.mesh,
                texture_or_null(shown),
                {.position = position, .text = description_text(certificate, position)});
    write_certificate(out / "tiles", certificate);
    return {"tiles"};
}

std::vector<std::string> export_one(const ReconstructionFolder& reconstruction,
                                    ExportFormat format,
                                    const std::optional<types::GeographicPosition>& position,
                                    const nlohmann::json& certificate,
                                    const std::filesystem::path& out,
                                    const WholeImage& whole_image) {
    switch (format) {
        case ExportFormat::Kitti:
            write_kitti(out / "trajectory_kitti.txt", reconstruction.trajectory());
            return {"trajectory_kitti.txt"};
        case ExportFormat::Euroc:
            write_euroc(out / "trajectory_euroc.csv", reconstruction.trajectory());
            return {"trajectory_euroc.csv"};
        case ExportFormat::Obj:
            return export_obj(reconstruction, certificate_line(certificate), out);
        case ExportFormat::Ply:
            return export_ply(reconstruction, certificate_line(certificate), out);
        case ExportFormat::Geotiff: return export_geotiff(reconstruction, position, out);
        case ExportFormat::Colmap:
            return export_posed_images(reconstruction,
                                       certificate,
                                       whole_image,
                                       out / "colmap",
                                       out / "colmap/sparse/0",
                                       write_colmap);
        case ExportFormat::Nerfstudio:
            return export_posed_images(reconstruction,
                                       certificate,
                                       whole_image,
                                       out / "nerfstudio",
                                       out / "nerfstudio",
                                       write_nerfstudio);
        case ExportFormat::Las:
            return export_las(reconstruction, LasStorage::Plain, position, certificate, out);
        case ExportFormat::Laz:
            return export_las(reconstruction, LasStorage::Laszip, position, certificate, out);
        case ExportFormat::E57:
            require_surface(reconstruction, "cloud.ply");
            write_e57(out / "cloud.e57",
                      CloudPlyReader(reconstruction.path() / "cloud.ply"),
                      certificate_line(certificate));
            return {"cloud.e57"};
        case ExportFormat::Tiles: return export_tiles(reconstruction, position, certificate, out);
        case ExportFormat::Mcap:
            write_mcap(out / "reconstruction.mcap",
                       reconstruction,
                       thinned_cloud(reconstruction),
                       certificate_line(certificate));
            return {"reconstruction.mcap"};
    }
    return {};
}

}  // namespace

std::vector<ExportFormat> export_formats(std::string_view list) {
    std::vector<ExportFormat> formats;
    for (std::size_t start = 0; start < list.size();) {
        const std::size_t end = std::min(list.find(',', start), list.size());
        formats.push_back(
            enum_from_text<ExportFormat>(kTexts, list.substr(start, end - start), "export format"));
        start = end + 1;
    }
    return formats;
}

std::optional<types::GeographicPosition> position_of(const ReconstructionFolder& reconstruction) {
    const nlohmann::json::json_pointer pointer("/dive/position");
    if (!reconstruction.metrics().contains(pointer)) return std::nullopt;
    try {
        const nlohmann::json& json = reconstruction.metrics().at(pointer);
        types::GeographicPosition position{json.at("latitude_deg").get<double>(),
                                           json.at("longitude_deg").get<double>(),
                                           std::nullopt};
        if (json.contains("x_azimuth_deg"))
            position.x_azimuth_deg = json.at("x_azimuth_deg").get<double>();
        return position;
    } catch (const nlohmann::json::exception& error) {
        throw Error(ErrorCode::BadData,
                    (reconstruction.path() / "metrics.json").string() + ": " + error.what());
    }
}

std::vector<std::string> export_reconstruction(
    const ReconstructionFolder& reconstruction,
    const std::vector<ExportFormat>& formats,
    const std::optional<types::GeographicPosition>& position,
    const std::filesystem::path& out,
    const WholeImage& whole_image) {
    const nlohmann::json certificate = certificate_of(reconstruction.metrics());
    std::filesystem::create_directories(out);
    std::vector<std::string> names;
    for (const ExportFormat format : formats)
        for (std::string& name :
             export_one(reconstruction, format, position, certificate, out, whole_image))
            names.push_back(std::move(name));
    write_certificate(out, certificate);
    names.emplace_back("certificate.json");
    return names;
}

}  // namespace divemesh::io
