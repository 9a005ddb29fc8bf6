#pragma once

#include <filesystem>

#include "worker/io/las_header.hpp"
#include "worker/types/mesh.hpp"

namespace divemesh::io {

// Writes the vertices of a mesh as LAS 1.4 (ASPRS, revision 15): point format 7 with colours in
// steps of 256, coordinates in steps of 0.1 mm, and the extra bytes `sigma` (float, m) and
// `observations` (uint32), where 0 is no data. Records beside the points hold these extra bytes,
// the coordinate system as well-known text (UTM, or a local one in metres; heights are above the
// first pose in both) and the text. LasStorage::Laszip makes it a LAZ file of the same points in
// the same order. The same mesh gives the same bytes. Throws as AtomicFile and check_mesh do, and
// Error{BadData} for a mesh of more than 400 km.
void write_las(const std::filesystem::path& file,
               const types::Mesh& mesh,
               const LasDescription& description,
               LasStorage storage = LasStorage::Plain);

}  // namespace divemesh::io
