#pragma once

#include <string>
#include <vector>

namespace divemesh::io {

// Returns the point records of a LAZ file of point format 7 with eight extra bytes, decoded from
// the layout of LASzip's native extension for LAS 1.4: its chunk table, chunks and layers. Throws
// std::runtime_error where the file is not as that says, or has what our points never have: several
// returns, another layer than those of position, colour and extra bytes.
std::vector<std::string> laz_records(const std::string& file);

}  // namespace divemesh::io
