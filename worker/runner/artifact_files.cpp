#include "worker/runner/artifact_files.hpp"

#include <algorithm>
#include <cctype>
#include <fstream>

#include "schemas/content_hash.hpp"
#include "schemas/error.hpp"

namespace divemesh::runner {
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
           !artifact_name.ends_with(".las") && !artifact_name.ends_with(".laz") &&
           !artifact_name.ends_with(".e57") && !artifact_name.ends_with(".mcap") &&
           !artifact_name.starts_with("tiles/") && !artifact_name.starts_with("colmap/") &&
           !artifact_name.starts_with("nerfstudio/");
}

bool is_below(const fs::path& name) {
    return !name.empty() && name.is_relative() &&
           std::none_of(
               name.begin(), name.end(), [](const fs::path& part) { return part == ".."; });
}

std::string plain_name(const std::string& file_name) {
    constexpr std::size_t kMaxLetters = 64;
    const std::size_t too_many = file_name.size() - std::min(file_name.size(), kMaxLetters);
    std::string name = file_name.substr(too_many);
    for (char& c : name)
        if (std::isalnum(static_cast<unsigned char>(c)) == 0 && c != '.' && c != '-') c = '_';
    return name.find_first_not_of('.') == std::string::npos ? "file" : name;
}

}  // namespace divemesh::runner
