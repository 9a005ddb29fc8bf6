#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "worker/io/posed_images.hpp"
#include "worker/io/reconstruction_folder.hpp"
#include "worker/types/geographic_position.hpp"

namespace divemesh::io {

// Files for other programs, made from a reconstruction:
//   kitti    trajectory_kitti.txt   final poses, 3 x 4, a row per frame
//   euroc    trajectory_euroc.csv   the same with timestamps, EuRoC's columns
//   obj      mesh_obj.zip           mesh.glb, or mesh.ply if that has no texture, as OBJ
//   ply      mesh_ply.zip           the same as PLY with texture coordinates
//   geotiff  mosaic.tif, heights.tif, heights_sigma.tif   in UTM; needs a position
//   colmap   colmap/images, colmap/sparse/0  keyframes and up to 100,000 points as a sparse model;
//            the images are whole if export_reconstruction() is given them, else small
//   nerfstudio   nerfstudio/                 the same as transforms.json and points.ply
//   las      surface.las   vertices with sigma and number of observations; in UTM with a position
//   laz      surface.laz   the same, compressed
//   e57      cloud.e57     all points of the cloud with their colours
//   3dtiles  tiles/        the mesh of obj in levels of detail; earth-centred with a position
//   mcap     reconstruction.mcap   poses, up to 100,000 points and keyframes for Foxglove
enum class ExportFormat {
    Kitti,
    Euroc,
    Obj,
    Ply,
    Geotiff,
    Colmap,
    Nerfstudio,
    Las,
    Laz,
    E57,
    Tiles,
    Mcap
};

// Parses format names separated by commas. Throws Error{InvalidArgument} that lists the valid ones.
std::vector<ExportFormat> export_formats(std::string_view list);

// Returns the geographic position of the reconstruction's world, from its dive.json; nullopt if it
// has none. Throws Error{BadData} if the position cannot be read.
std::optional<types::GeographicPosition> position_of(const ReconstructionFolder& reconstruction);

// Writes the formats and certificate.json into `out`; returns the names of the files, and of the
// folder of a format that is one, which contains a certificate.json too. Throws Error{NotFound}
// that names a missing file of the reconstruction, Error{BadData} for a broken one, and
// Error{InvalidArgument} if a format needs a position that is not known.
std::vector<std::string> export_reconstruction(
    const ReconstructionFolder& reconstruction,
    const std::vector<ExportFormat>& formats,
    const std::optional<types::GeographicPosition>& position,
    const std::filesystem::path& out,
    const WholeImage& whole_image = {});

}  // namespace divemesh::io
