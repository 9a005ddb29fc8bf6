#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "schemas/finding.hpp"
#include "worker/types/geographic_position.hpp"

namespace divemesh::recording {

// A file that a dive was made from, or a folder as a whole.
struct ImportedFile {
    std::string name;  // "": none is kept
    std::string sha256;
    std::int64_t size_bytes = 0;
};

// Where a dive came from, for its dive.json.
struct Provenance {
    std::string name;  // of the dive; "": it has none
    std::vector<ImportedFile> files;
    std::vector<Finding> findings;  // which the dive tells whenever it is opened
    std::optional<types::GeographicPosition> position;  // where it was
};

// Reads files whole for their hash, which is that of their bytes after each other; `name` is that
// of all of them together.
ImportedFile imported_file(std::string name, const std::vector<std::filesystem::path>& files);

// Takes the names of the files away, also from findings, so that the same bytes give the same dive.
void remove_names(Provenance& provenance);

}  // namespace divemesh::recording
