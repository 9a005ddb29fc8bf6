#include "worker/pipeline/stage_cache.hpp"

#include <algorithm>
#include <cerrno>
#include <fcntl.h>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string_view>
#include <unistd.h>

#include "schemas/content_hash.hpp"
#include "schemas/error.hpp"
#include "schemas/file_descriptor.hpp"
#include "worker/base/cache_folder.hpp"
#include "worker/pipeline/link_or_copy.hpp"

namespace divemesh::pipeline {
namespace {

namespace fs = std::filesystem;

struct CachedFile {
    std::string name;  // relative, may contain folders
    std::int64_t size_bytes = 0;
    std::string sha256;
};

[[noreturn]] void give_up(const fs::path& file) {
    throw Error(ErrorCode::Unavailable, "cannot use the stage cache file " + file.string());
}

void sync(const fs::path& path, int flags) {
    const FileDescriptor opened(::open(path.c_str(), flags | O_CLOEXEC));
    if (!opened.is_open() || ::fsync(opened.get()) != 0) give_up(path);
}

// Returns the hash of a file, read in chunks.
std::string hash_of(const fs::path& file) {
    std::ifstream stream(file, std::ios::binary);
    if (!stream) give_up(file);
    Sha256 hash;
    std::vector<char> buffer(1 << 20);
    while (stream) {
        stream.read(buffer.data(), static_cast<std::streamsize>(buffer.size()));
        hash.update({buffer.data(), static_cast<std::size_t>(stream.gcount())});
    }
    if (stream.bad()) give_up(file);
    return hash.hex();
}

std::vector<std::string> files_below(const fs::path& folder, const std::string& name) {
    if (fs::is_regular_file(fs::symlink_status(folder / name))) return {name};
    std::vector<std::string> names;
    for (const auto& entry : fs::recursive_directory_iterator(folder / name))
        if (fs::is_regular_file(entry.symlink_status()))
            names.push_back(entry.path().lexically_relative(folder).generic_string());
    std::sort(names.begin(), names.end());
    return names;
}

// Returns true if the name stays inside the entry; a list may be damaged or written by another
// program.
bool stays_inside(const std::string& name) {
    const fs::path path(name);
    return !path.empty() && path.is_relative() &&
           std::none_of(path.begin(), path.end(), [](const fs::path& part) {
               return part == ".." || part == "." || part.empty();
           });
}

nlohmann::json to_json(const std::vector<CachedFile>& files) {
    nlohmann::json list = nlohmann::json::array();
    for (const CachedFile& file : files)
        list.push_back(
            {{"name", file.name}, {"size_bytes", file.size_bytes}, {"sha256", file.sha256}});
    return list;
}

// Reads the list of an entry; throws if it is not one of this program.
std::vector<CachedFile> read_list(const fs::path& entry) {
    std::ifstream stream(entry / base::kCacheListName);
    std::vector<CachedFile> files;
    for (const auto& item : nlohmann::json::parse(stream)) {
        CachedFile file{item.at("name").get<std::string>(),
                        item.at("size_bytes").get<std::int64_t>(),
                        item.at("sha256").get<std::string>()};
        if (!stays_inside(file.name) || file.size_bytes < 0) give_up(entry);
        files.push_back(std::move(file));
    }
    return files;
}

void write_list(const fs::path& entry, const std::vector<CachedFile>& files) {
    std::ofstream stream(entry / base::kCacheListName);
    stream << to_json(files);
    stream.close();
    if (!stream) give_up(entry / base::kCacheListName);
    sync(entry / base::kCacheListName, O_RDONLY);
}

void sync_folders(const fs::path& entry) {
    for (const auto& below : fs::recursive_directory_iterator(entry))
        if (below.is_directory()) sync(below.path(), O_RDONLY | O_DIRECTORY);
    sync(entry, O_RDONLY | O_DIRECTORY);
}

std::int64_t size_of(const std::vector<CachedFile>& files) {
    std::int64_t bytes = 0;
    for (const CachedFile& file : files) bytes += file.size_bytes;
    return bytes;
}

}  // namespace

StageCache::StageCache(fs::path folder, std::int64_t max_bytes)
    : folder_(max_bytes > 0 ? std::move(folder) : fs::path()), max_bytes_(max_bytes) {
    std::error_code failure;
    if (is_open()) fs::create_directories(folder_, failure);
    if (failure) folder_.clear();
}

bool StageCache::fetch(const std::string& key, const fs::path& into) {
    if (!is_open()) return false;
    const fs::path entry = folder_ / key;
    std::vector<fs::path> fetched;
    try {
        if (!fs::exists(entry / base::kCacheListName)) return false;
        for (const CachedFile& file : read_list(entry)) {
            fetched.push_back(into / file.name);
            link_or_copy(entry / file.name, fetched.back());
            if (static_cast<std::int64_t>(fs::file_size(fetched.back())) != file.size_bytes ||
                hash_of(fetched.back()) != file.sha256)
                give_up(fetched.back());
        }
        fs::last_write_time(entry / base::kCacheListName, fs::file_time_type::clock::now());
        return true;
    } catch (const std::exception&) {  // damaged, or removed by another process meanwhile
        std::error_code ignored;
        for (const fs::path& file : fetched) fs::remove(file, ignored);
        drop(key);
        return false;
    }
}

void StageCache::store(const std::string& key,
                       const fs::path& from,
                       const std::vector<std::string>& names) {
    if (!is_open()) return;
    try {
        write(key, from, names);
        base::limit_cache(folder_, max_bytes_);
    } catch (const std::exception&) {  // most likely a full disk; the stage is still done
    }
}

void StageCache::write(const std::string& key,
                       const fs::path& from,
                       const std::vector<std::string>& names) const {
    if (fs::exists(folder_ / key)) return;
    const fs::path entry = base::make_temporary_entry(folder_);
    try {
        std::vector<CachedFile> files;
        for (const std::string& name : names)
            for (const std::string& file : files_below(from, name)) {
                link_or_copy(from / file, entry / file);
                sync(entry / file, O_RDONLY);
                files.push_back({file,
                                 static_cast<std::int64_t>(fs::file_size(entry / file)),
                                 hash_of(entry / file)});
            }
        if (size_of(files) > max_bytes_) give_up(entry);
        write_list(entry, files);
        sync_folders(entry);
        // Fails if another process was first, with the same bytes.
        fs::rename(entry, folder_ / key);
        sync(folder_, O_RDONLY | O_DIRECTORY);
    } catch (const std::exception&) {
        std::error_code ignored;
        fs::remove_all(entry, ignored);
        throw;
    }
}

void StageCache::drop(const std::string& key) {
    if (is_open()) base::remove_cache_entry(folder_, folder_ / key);
}

}  // namespace divemesh::pipeline
