#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>

#include "worker/base/atomic_file.hpp"
#include "worker/types/mesh.hpp"

namespace divemesh::io {

// Writes a binary little-endian PLY. Vertices: x y z nx ny nz (float), red green blue (uchar),
// sigma and sigma_local (float, m; 0: unknown), num_observations (uint; 0: unknown). The colours
// are omitted if the mesh has none. Throws as AtomicFile and check_mesh do.
void write_ply(const std::filesystem::path& file, const types::Mesh& mesh);

// Writes a cloud as PLY, point by point: x y z (float), red green blue (uchar). The number of
// points must be known in advance. `remark` is a comment of one line.
class CloudPlyWriter {
public:
    CloudPlyWriter(const std::filesystem::path& file,
                   std::int64_t num_points,
                   const std::string& remark = "");
    void add(const Eigen::Vector3f& p_world, const types::Color& color);
    void commit() { output_.commit(); }  // the file does not exist before

private:
    base::AtomicFile output_;
};

// Reads any PLY of triangles, polygons (split into fans) or only points: ascii or binary of either
// byte order, properties in any order; unknown ones are skipped. Checks counts against the file
// size before it allocates memory. Throws Error{NotFound}, or Error{BadData} that names the file
// and the problem.
types::Mesh read_ply(const std::filesystem::path& file);
// Reads a PLY from memory; `name` is for messages.
types::Mesh parse_ply(std::string_view bytes, const std::string& name);

}  // namespace divemesh::io
