#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>

namespace divemesh::bench {

// The results of runs in a folder, one JSON each, written when the run ends: what was measured
// before an interruption is not measured again. A result counts only for the program that gave it,
// told by the bytes of the file.
class KeptResults {
public:
    KeptResults(std::filesystem::path folder, const std::filesystem::path& program);

    std::optional<nlohmann::json> find(const std::string& run) const;
    void keep(const std::string& run, const nlohmann::json& result) const;

private:
    std::filesystem::path file_of(const std::string& run) const;

    std::filesystem::path folder_;
    std::string program_sha256_;
};

}  // namespace divemesh::bench
