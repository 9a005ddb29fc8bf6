#pragma once

#include <map>
#include <string>
#include <vector>

#include "schemas/artifact.hpp"
#include "schemas/truth_file.hpp"

namespace divemesh::storage {

// What a report or a comparison reads besides its dive.
struct JobInputs {
    // The artifacts of the reconstruction `job`, then of the one it is compared `with`.
    std::vector<std::vector<Artifact>> reconstructions;
    std::map<std::string, TruthFile> truth;              // by the option that names it
    std::vector<TruthFile> set_aside;                    // newer than those, but unreadable
    std::map<std::string, std::vector<double>> history;  // earlier values of metrics, oldest first
};

}  // namespace divemesh::storage
