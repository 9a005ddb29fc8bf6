#include "worker/artifact_files.hpp"

#include <algorithm>
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

}  // namespace divemesh::worker
