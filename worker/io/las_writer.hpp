#pragma once

#include <chrono>
#include <filesystem>
#include <optional>
#include <string>

#include "worker/io/geographic_frame.hpp"
#include "worker/types/mesh.hpp"

namespace divemesh::io {

// What a LAS file states besides its points.
struct LasDescription {
    std::optional<UtmFrame> utm;                      // nullopt: the world's own coordinates
    std::string text;                                 // one line of ASCII about the file
    std::optional<std::chrono::year_month_day> date;  // nullopt: unknown
};

// Writes the vertices of a mesh as LAS 1.4 (ASPRS, revision 15): point format 7 with colours in
// steps of 256, coordinates in steps of 0.1 mm, and the extra bytes `sigma` (float, m) and
// `observations` (uint32), where 0 is no data. Records beside the points hold these extra bytes,
// the coordinate system as well-known text (UTM, or a local one in metres; heights are above the
// first pose in both) and the text. The same mesh gives the same bytes. Throws as AtomicFile and
// check_mesh do, and Error{BadData} for a mesh of more than 400 km.
void write_las(const std::filesystem::path& file,
               const types::Mesh& mesh,
               const LasDescription& description);

}  // namespace divemesh::io
