#pragma once

#include <string>

#include "schemas/reconstruction_options.hpp"

namespace divemesh::worker {

// What the result of each stage depends on: the dive, the program, and the options that this stage
// or one before it reads. Two runs whose keys are equal make the same bytes; a run that differs in
// a later option starts where that is read first.
struct StageKeys {
    std::string track;
    std::string optimise;
    std::string fuse;
    std::string mesh;
    std::string texture;
};

StageKeys stage_keys(const std::string& program,
                     const std::string& content_sha256,
                     const ReconstructionOptions& options);

}  // namespace divemesh::worker
