#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>

#include "worker/io/ply_header.hpp"
#include "worker/types/mesh.hpp"

namespace divemesh::io {

// Reads a cloud.ply as CloudPlyWriter writes it, point by point, so that it need not fit into
// memory. Throws Error{NotFound}, or Error{BadData} that names the file and the problem; a count
// that the file is too short for is found at once.
class CloudPlyReader {
public:
    explicit CloudPlyReader(const std::filesystem::path& file);

    std::uint64_t num_points() const { return vertices_.count; }
    // Calls visit(p_world, color) for each point in its order.
    void for_each(
        const std::function<void(const Eigen::Vector3f&, const types::Color&)>& visit) const;

private:
    std::filesystem::path file_;
    std::size_t header_bytes_ = 0;
    PlyElement vertices_;
};

}  // namespace divemesh::io
