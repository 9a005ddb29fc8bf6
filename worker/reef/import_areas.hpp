#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>

#include "worker/io/reconstruction_folder.hpp"

namespace divemesh::reef {

// How areas of other programs are read; empty: as the file states it.
struct AreaImport {
    std::string crs;           // "world" or "EPSG:4326", "EPSG:326zz", "EPSG:327zz"
    std::string name_column;   // by default name or id
    std::string label_column;  // by default label, class, species or TL_Class
    std::string map;           // of a TagLab project with several maps
    bool fill_holes = false;   // take the outer outline of areas with holes, instead of refusing
};

// Returns the areas of a file as areas.json has them, in the world of a reconstruction, whatever
// program wrote it: GeoJSON, a shapefile (.shp), a TagLab project, or areas.json itself. Points get
// the height of the surface. A name that is used again gets a number, a feature of several parts is
// an area for each. Throws Error{NotFound}, Error{BadData} or Error{InvalidArgument} that names the
// file, the area and what to do.
nlohmann::json import_areas(const std::filesystem::path& file,
                            const io::ReconstructionFolder& reconstruction,
                            const AreaImport& how);

}  // namespace divemesh::reef
