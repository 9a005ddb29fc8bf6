#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include "worker/volume/mesh.hpp"

namespace divemesh::worker {

// Binary little-endian PLY. Vertices: x y z nx ny nz (float), red green blue (uchar), sigma
// (float, m; 0: unknown), num_observations (uint; 0: unknown). Colours are left out when the mesh
// has none. Throws as AtomicFile and check_mesh do.
void write_ply(const std::filesystem::path& file, const Mesh& mesh);

// x y z (float) and, when the cloud has them, red green blue (uchar).
void write_cloud_ply(const std::filesystem::path& file, const PointCloud& cloud);

// Any PLY of triangles or polygons (cut into fans) or bare points: ascii or binary of either byte
// order, properties in any order, unknown ones skipped. Counts are checked against the size of the
// file before anything is allocated. Throws Error{NotFound}, or Error{BadData} that names the file
// and what is wrong in it.
Mesh read_ply(const std::filesystem::path& file);
// The same from memory; `name` is for messages.
Mesh parse_ply(std::string_view bytes, const std::string& name);

}  // namespace divemesh::worker
