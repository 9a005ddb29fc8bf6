#pragma once

#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <vector>

#include "worker/io/ply.hpp"
#include "worker/types/mesh.hpp"

namespace divemesh::synthetic {

// Writes the files of a reconstruction's folder that a comparison reads; `more` goes into
// metrics.json.
inline void write_reconstruction(const std::filesystem::path& folder,
                                 const types::Mesh& mesh,
                                 const nlohmann::json& more = nlohmann::json::object()) {
    std::filesystem::create_directories(folder);
    io::write_ply(folder / "mesh.ply", mesh);
    nlohmann::json metrics = {
        {"version", "0.1.0"},
        {"preset", "standard"},
        {"dive", {{"name", "<b>" + folder.filename().string() + "</b>"}, {"content_sha256", ""}}}};
    metrics.update(more);
    std::ofstream(folder / "metrics.json") << metrics;
}

// Writes keyframes.json with one keyframe a second, the first at 0 s, that look down from 1.5 m.
// `x_m`: where each of them is.
inline void write_keyframes(const std::filesystem::path& folder, const std::vector<double>& x_m) {
    nlohmann::json keyframes = nlohmann::json::array();
    for (std::size_t i = 0; i < x_m.size(); ++i)
        keyframes.push_back({{"frame_index", i},
                             {"timestamp_ns", 1'000'000'000 * static_cast<std::int64_t>(i)},
                             {"position_m", {x_m[i], 0.0, 1.5}},
                             {"orientation_wxyz", {0.0, 1.0, 0.0, 0.0}}});
    std::filesystem::create_directories(folder);
    std::ofstream(folder / "keyframes.json")
        << nlohmann::json{{"focal_px", 300.0},
                          {"principal_point_px", {320.0, 240.0}},
                          {"image_size_px", {640.0, 480.0}},
                          {"keyframes", keyframes}};
}

// Returns a tracking segment as metrics.json states it, recorded from `first_s` to `last_s`.
inline nlohmann::json segment_json(int num_frames, std::int64_t first_s, std::int64_t last_s) {
    const nlohmann::json interval = {{"first_ns", 1'000'000'000 * first_s},
                                     {"last_ns", 1'000'000'000 * last_s}};
    return {{"num_frames", num_frames}, {"intervals", nlohmann::json::array({interval})}};
}

// Returns the height of a cone around the origin.
inline double cone(double x, double y, double radius_m, double height_m) {
    return height_m * std::max(0.0, 1.0 - std::hypot(x, y) / radius_m);
}

}  // namespace divemesh::synthetic
