#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>

#include "worker/base/atomic_file.hpp"
#include "worker/types/mesh.hpp"

namespace divemesh::io {

// Binary little-endian PLY. Vertices: x y z nx ny nz (float), red green blue (uchar), sigma and
// sigma_local (float, m; 0: unknown), num_observations (uint; 0: unknown). Colours are left out
// when the mesh has none. Throws as AtomicFile and check_mesh do.
void write_ply(const std::filesystem::path& file, const types::Mesh& mesh);

// x y z (float), red green blue (uchar), one point after the other; the number of points is known
// before.
class CloudPlyWriter {
public:
    CloudPlyWriter(const std::filesystem::path& file, std::int64_t num_points);
    void add(const Eigen::Vector3f& p_world, const types::Color& color);
    void commit() { output_.commit(); }  // nothing is there before

private:
    base::AtomicFile output_;
};

// Any PLY of triangles or polygons (cut into fans) or bare points: ascii or binary of either byte
// order, properties in any order, unknown ones skipped. Counts are checked against the size of the
// file before anything is allocated. Throws Error{NotFound}, or Error{BadData} that names the file
// and what is wrong in it.
types::Mesh read_ply(const std::filesystem::path& file);
// The same from memory; `name` is for messages.
types::Mesh parse_ply(std::string_view bytes, const std::string& name);

}  // namespace divemesh::io
