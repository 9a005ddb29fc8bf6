#pragma once

#include <cstdint>
#include <string>

#include "worker/recording/input_file.hpp"

namespace divemesh::recording {

// Where a dive came from, for its dive.json.
struct Provenance {
    std::string file;
    std::string sha256;
    std::int64_t size_bytes = 0;
};

// Reads the whole file for its hash.
Provenance provenance_of(const InputFile& file);

}  // namespace divemesh::recording
