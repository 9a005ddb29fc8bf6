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
    // Returns the relative error of the stated baseline. It is drawn for this dive from a normal
    // distribution with the standard deviation that bounds assume for a calibration, 0.1 %.
    double baseline_error() const;
};

// Returns an open path in each of three scenes, and two laps in one of them.
std::vector<SimulatedDive> dives_of_seed(int seed);

// Reconstructs a dive without texture. Throws std::runtime_error with the program's last output if
// it fails.
void reconstruct_surface(const std::filesystem::path& program,
                         const std::filesystem::path& dive,
                         const std::filesystem::path& out);

// Dives with known truth, kept in a folder once they are rendered. They have small images and a
// path of 3 m. Dive and model take a minute of CPU time, two minutes for two laps.
struct SimulatedDives {
    std::filesystem::path program;  // divemesh
    std::filesystem::path cache;

    // Returns the folder of a dive, rendered if it is missing. Throws std::runtime_error if that
    // fails.
    std::filesystem::path rendered(const SimulatedDive& dive) const;
    // Reconstructs a copy of the dive whose calibration states the baseline with the dive's error,
    // as a real calibration would. The ends of known distances are marked in the images of the true
    // rig.
    void reconstruct(const SimulatedDive& dive, const std::filesystem::path& out) const;
};

}  // namespace divemesh::bench
