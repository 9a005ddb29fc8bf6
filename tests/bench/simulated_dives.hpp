#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace divemesh::bench {

struct SimulatedDive {
    std::string scene;
    int seed = 0;
    int num_laps = 0;  // 0: an open path

    std::string name() const;
    // What bounds take a calibration's baseline and focal length to err by, drawn for this dive
    // from a normal number of 0.1 %, relative.
    double baseline_error() const;
};

// Three scenes, and two laps in one of them.
std::vector<SimulatedDive> dives_of_seed(int seed);

// Without texture. Throws std::runtime_error with what the program said last.
void reconstruct_surface(const std::filesystem::path& program,
                         const std::filesystem::path& dive,
                         const std::filesystem::path& out);

// Dives whose truth is known, kept in a folder once they are rendered: small pictures of 3 m, a
// minute of processor time for dive and model, for two laps two.
struct SimulatedDives {
    std::filesystem::path program;  // divemesh
    std::filesystem::path cache;

    std::filesystem::path rendered(const SimulatedDive& dive) const;
    // As it is for whoever calibrated a rig: of a copy whose calibration has a baseline longer by
    // the dive's error, known distances marked as the true rig saw their ends.
    void reconstruct(const SimulatedDive& dive, const std::filesystem::path& out) const;
};

}  // namespace divemesh::bench
