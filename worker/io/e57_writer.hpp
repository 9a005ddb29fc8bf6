#pragma once

#include <filesystem>
#include <string>

#include "worker/io/cloud_ply_reader.hpp"

namespace divemesh::io {

// Writes a cloud as E57 1.0 (ASTM E2807-11): one scan in data3D with cartesianX, Y and Z as floats
// of single precision (m, our world, z up) and colorRed, Green and Blue of 8 bits, their limits,
// and `text` as its description. Points are read and written one packet at a time. Its GUIDs come
// from the text and the number of points, and it states no time: the same cloud gives the same
// bytes. Throws Error{BadData} without points, and as AtomicFile and CloudPlyReader do.
void write_e57(const std::filesystem::path& file,
               const CloudPlyReader& cloud,
               const std::string& text);

}  // namespace divemesh::io
