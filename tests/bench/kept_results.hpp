#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>

namespace divemesh::bench {

// A folder of results, one JSON file for each run, so that an interrupted bench does not repeat
// finished runs. A result is valid only for the program that made it, identified by the SHA-256 of
// its file.
class KeptResults {
public:
    KeptResults(std::filesystem::path folder, const std::filesystem::path& program);

    // Returns the kept result; nullopt if there is none of this program.
    std::optional<nlohmann::json> find(const std::string& run) const;
    // Throws std::runtime_error if the result cannot be written.
    void keep(const std::string& run, const nlohmann::json& result) const;

private:
    std::filesystem::path file_of(const std::string& run) const;

    std::filesystem::path folder_;
    std::string program_sha256_;
};

}  // namespace divemesh::bench
