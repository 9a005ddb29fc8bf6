#pragma once

#include <filesystem>
#include <string>

#include "schemas/truth_file.hpp"

namespace divemesh::report {

// Returns why a report cannot read a file of truth; "" if it can.
std::string problem_of_truth(TruthKind kind, const std::filesystem::path& file);

}  // namespace divemesh::report
