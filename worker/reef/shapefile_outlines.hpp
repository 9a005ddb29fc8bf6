#pragma once

#include <string_view>

#include "worker/reef/dbf_table.hpp"
#include "worker/reef/outline_file.hpp"

namespace divemesh::reef {

// Returns whether bytes begin as the main file of a shapefile (.shp) does.
bool is_shapefile(std::string_view bytes);

// Returns the polygons and lines of the main file of a shapefile (ESRI Shapefile Technical
// Description, 1998), those with Z and M too, with the rows of its table as columns; an empty table
// gives none. Rings within another that run counter-clockwise are holes. Points are left out.
// Throws Error{BadData} that names the record, or if the table has not a row for each.
OutlineFile shapefile_outlines(std::string_view bytes, const DbfTable& table);

}  // namespace divemesh::reef
