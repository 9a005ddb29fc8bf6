#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "worker/io/reconstruction_folder.hpp"
#include "worker/types/geographic_position.hpp"

namespace divemesh::io {

// Files for other programs, made of a reconstruction's own:
//   kitti    trajectory_kitti.txt   final poses, 3 x 4, a row a frame
//   euroc    trajectory_euroc.csv   the same with stamps, EuRoC's columns
//   obj      mesh_obj.zip           Wavefront OBJ and MTL
//   geotiff  mosaic.tif, mosaic_height.tif   in UTM; needs a position
enum class ExportFormat { Kitti, Euroc, Obj, Geotiff };

// Words separated by commas; throws Error{InvalidArgument} that lists them.
std::vector<ExportFormat> export_formats(std::string_view list);

// Where the reconstruction's world lies, as its dive.json said.
std::optional<types::GeographicPosition> position_of(const ReconstructionFolder& reconstruction);

// Writes into `out` and returns the names of the files. Throws Error{InvalidArgument} where a
// format needs what is not there: a surface, a mosaic, a position.
std::vector<std::string> export_reconstruction(
    const ReconstructionFolder& reconstruction,
    const std::vector<ExportFormat>& formats,
    const std::optional<types::GeographicPosition>& position,
    const std::filesystem::path& out);

}  // namespace divemesh::io
