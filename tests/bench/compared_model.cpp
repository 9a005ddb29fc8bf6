// Writes as much of a reconstruction's folder as `divemesh compare` reads, of a place whose change
// is known, and prints that change as JSON.

#include <CLI/CLI.hpp>
#include <iostream>

#include "tests/bench/compared_place.hpp"
#include "tests/synthetic/small_reconstruction.hpp"

namespace {

using nlohmann::json;

json keyframes_of(const divemesh::bench::ComparedPlace& place, int year) {
    const Eigen::Quaterniond q(
        Eigen::AngleAxisd(place.heading_rad(year), Eigen::Vector3d::UnitZ()) *
        Eigen::AngleAxisd(3.14159265358979, Eigen::Vector3d::UnitX()));
    json keyframes = json::array();
    for (const Eigen::Vector3d& eye : place.eyes(year))
        keyframes.push_back({{"frame_index", keyframes.size()},
                             {"timestamp_ns", 1'000'000'000 * keyframes.size()},
                             {"position_m", {eye.x(), eye.y(), eye.z()}},
                             {"orientation_wxyz", {q.w(), q.x(), q.y(), q.z()}}});
    return {{"focal_px", 500.0},
            {"principal_point_px", {320.0, 240.0}},
            {"image_size_px", {640.0, 480.0}},
            {"keyframes", keyframes}};
}

}  // namespace

int main(int argc, char** argv) {
    std::filesystem::path out;
    unsigned seed = 1;
    std::size_t num_vertices = 1'000'000;
    int year = 1;
    CLI::App app{"Writes a model to compare and prints its known change."};
    app.add_option("--out", out, "folder to write")->required();
    app.add_option("--seed", seed, "seed of the place")->capture_default_str();
    app.add_option("--vertices", num_vertices, "approximate number of vertices, 5 mm apart")
        ->capture_default_str();
    app.add_option("--year", year, "year of the survey, 1 or 2")
        ->check(CLI::Range(1, 2))
        ->capture_default_str();
    CLI11_PARSE(app, argc, argv);
    const divemesh::bench::ComparedPlace place(seed, num_vertices);
    const divemesh::types::Mesh mesh = place.model(year);
    divemesh::synthetic::write_reconstruction(out, mesh);
    std::ofstream(out / "keyframes.json") << keyframes_of(place, year);
    std::cout << json{{"num_vertices", mesh.vertices.size()},
                      {"area_m2", place.area_m2()},
                      {"grown_m3", place.grown_m3()},
                      {"lost_m3", place.lost_m3()}}
              << "\n";
}
