#pragma once

#include <nlohmann/json.hpp>

#include "worker/reef/outline_file.hpp"

namespace divemesh::reef {

// Returns the polygons and lines of a GeoJSON document (RFC 7946), with the properties of each
// feature as columns. The older member "crs" is read, as GDAL and QGIS write it for other systems
// than longitude and latitude; without one `coordinates` is Unstated. Points are left out. Throws
// Error{BadData} that names the feature.
OutlineFile geojson_outlines(const nlohmann::json& document);

}  // namespace divemesh::reef
