#pragma once

#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "worker/io/ply.hpp"
#include "worker/types/mesh.hpp"

namespace divemesh::synthetic {

// Writes the files of a reconstruction's folder that a comparison reads.
inline void write_reconstruction(const std::filesystem::path& folder, const types::Mesh& mesh) {
    std::filesystem::create_directories(folder);
    io::write_ply(folder / "mesh.ply", mesh);
    std::ofstream(folder / "metrics.json") << nlohmann::json{
        {"version", "0.1.0"},
        {"preset", "standard"},
        {"dive", {{"name", "<b>" + folder.filename().string() + "</b>"}, {"content_sha256", ""}}}};
}

// Returns the height of a cone around the origin.
inline double cone(double x, double y, double radius_m, double height_m) {
    return height_m * std::max(0.0, 1.0 - std::hypot(x, y) / radius_m);
}

}  // namespace divemesh::synthetic
