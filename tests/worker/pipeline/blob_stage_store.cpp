#include "tests/worker/pipeline/blob_stage_store.hpp"

#include <fstream>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "schemas/content_hash.hpp"
#include "tests/temporary_folder.hpp"

namespace divemesh::pipeline {
namespace {

namespace fs = std::filesystem;

std::string folder_of(const std::string& key) { return "stages/" + key + "/"; }

std::string list_of(const std::string& key) { return folder_of(key) + "files.json"; }

std::vector<std::string> files_below(const fs::path& folder, const std::string& name) {
    if (fs::is_regular_file(folder / name)) return {name};
    std::vector<std::string> files;
    for (const auto& entry : fs::recursive_directory_iterator(folder / name))
        if (entry.is_regular_file())
            files.push_back(entry.path().lexically_relative(folder).generic_string());
    return files;
}

std::string content(const fs::path& file) {
    std::ifstream stream(file, std::ios::binary);
    return {std::istreambuf_iterator<char>(stream), {}};
}

}  // namespace

std::string BlobStageStore::blob_of(const std::string& key, const std::string& file) {
    return folder_of(key) + "files/" + file;
}

std::string BlobStageStore::read(const std::string& blob) const {
    const auto reader = blobs_.open(blob);
    std::string bytes(static_cast<std::size_t>(reader->size_bytes()), '\0');
    for (std::size_t done = 0; done < bytes.size();) {
        const auto n = reader->read_at(static_cast<std::int64_t>(done),
                                       {bytes.data() + done, bytes.size() - done});
        if (n == 0) throw std::runtime_error(blob + " is cut short");
        done += n;
    }
    return bytes;
}

bool BlobStageStore::fetch(const std::string& key, const fs::path& into) {
    if (!blobs_.exists(list_of(key))) return false;
    std::vector<fs::path> fetched;
    try {
        for (const auto& file : nlohmann::json::parse(read(list_of(key)))) {
            const auto name = file.at("name").get<std::string>();
            const std::string bytes = read(blob_of(key, name));
            if (sha256_hex(bytes) != file.at("sha256")) throw std::runtime_error(name);
            fetched.push_back(into / name);
            fs::create_directories(fetched.back().parent_path());
            std::ofstream(fetched.back(), std::ios::binary) << bytes;
        }
        return true;
    } catch (const std::exception&) {
        for (const fs::path& file : fetched) fs::remove(file);
        drop(key);
        return false;
    }
}

void BlobStageStore::store(const std::string& key,
                           const fs::path& from,
                           const std::vector<std::string>& names) {
    if (blobs_.exists(list_of(key))) return;
    try {
        nlohmann::json list = nlohmann::json::array();
        for (const std::string& name : names)
            for (const std::string& file : files_below(from, name)) {
                blobs_.put_file(blob_of(key, file), from / file);
                list.push_back({{"name", file}, {"sha256", sha256_hex(content(from / file))}});
            }
        const TemporaryFolder folder;
        std::ofstream(folder / "files.json") << list;
        blobs_.put_file(list_of(key), folder / "files.json");
    } catch (const std::exception&) {
        drop(key);
    }
}

void BlobStageStore::drop(const std::string& key) { blobs_.remove_prefix(folder_of(key)); }

}  // namespace divemesh::pipeline
