#include "worker/artifact_files.hpp"

#include <algorithm>
#include <cctype>
#include <fstream>

#include "schemas/content_hash.hpp"
#include "schemas/error.hpp"

namespace divemesh::worker {
namespace {

namespace fs = std::filesystem;

std::string sha256_of_file(const fs::path& file) {
    std::ifstream stream(file, std::ios::binary);
    if (!stream) throw Error(ErrorCode::Unavailable, "cannot read " + file.string());
    Sha256 hash;
    std::vector<char> buffer(1 << 20);
    while (stream) {
        stream.read(buffer.data(), static_cast<std::streamsize>(buffer.size()));
        hash.update({buffer.data(), static_cast<std::size_t>(stream.gcount())});
    }
    return hash.hex();
}

}  // namespace

std::vector<Artifact> list_artifacts(const fs::path& folder) {
    std::vector<fs::path> files;
    for (const auto& entry : fs::recursive_directory_iterator(folder))
        if (entry.is_regular_file() && !entry.is_symlink()) files.push_back(entry.path());
    std::sort(files.begin(), files.end());

    std::vector<Artifact> artifacts;
    for (const fs::path& file : files) {
        Artifact artifact;
        artifact.name = file.lexically_relative(folder).generic_string();
        artifact.media_type = media_type_of(artifact.name);
        artifact.sha256 = sha256_of_file(file);
        artifact.size_bytes = static_cast<std::int64_t>(fs::file_size(file));
        artifacts.push_back(std::move(artifact));
    }
    return artifacts;
}

bool is_read_again(const std::string& artifact_name) {
    return artifact_name != "cloud.ply" && artifact_name != "report.html" &&
           !artifact_name.ends_with(".glb") && !artifact_name.ends_with(".zip") &&
           !artifact_name.starts_with("tiles/");
}

bool is_below(const fs::path& name) {
    return !name.empty() && name.is_relative() &&
           std::none_of(
               name.begin(), name.end(), [](const fs::path& part) { return part == ".."; });
}

std::string plain_extension(const std::string& file_name) {
    constexpr std::size_t kMostLetters = 8;
    const auto dot = file_name.rfind('.');
    if (dot == std::string::npos || file_name.size() - dot - 1 > kMostLetters) return "";
    const std::string letters = file_name.substr(dot + 1);
    const auto is_plain = [](unsigned char c) { return std::isalnum(c) != 0; };
    return std::all_of(letters.begin(), letters.end(), is_plain) ? "." + letters : "";
}

}  // namespace divemesh::worker
