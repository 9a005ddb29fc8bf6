#include "worker/dive/dive_files.hpp"

#include <algorithm>

#include "schemas/desktop_files.hpp"
#include "worker/dive/entry_name.hpp"
#include "worker/dive/refusal.hpp"

namespace divemesh::dive {
namespace {

// Returns "monday/" for "monday/mav0/cam0/sensor.yaml"; nullopt for all but the calibration of a
// dive's left camera.
std::optional<std::string> folder_of_dive(std::string_view path) {
    constexpr std::string_view kCalibration = "cam0/sensor.yaml";
    constexpr std::string_view kRoot = "mav0/";
    if (!path.ends_with(kCalibration)) return std::nullopt;
    path.remove_suffix(kCalibration.size());
    if (path.ends_with(kRoot)) path.remove_suffix(kRoot.size());
    if (!path.empty() && !path.ends_with('/')) return std::nullopt;
    return std::string(path);
}

[[noreturn]] void refuse(const UnusedLinks& links) {
    std::string message = "this is not a dive: it has neither a folder mav0/ nor cam0/";
    std::string remedy =
        "Give the folder that contains mav0/cam0/data.csv, mav0/cam0/sensor.yaml and so on, or "
        "make "
        "a dive of other recordings and of folders of images by divemesh import.";
    if (links.count > 0) {
        message += "; symbolic links in it that give no file: " + std::to_string(links.count);
        message += ", the first: " + printable(links.first) + " is " + links.problem;
        remedy =
            "Fetch what the links stand for, or replace them by the files: cp -rL FOLDER COPY.";
    }
    throw Refusal("not_a_dive", "", message, remedy);
}

}  // namespace

DiveFiles::DiveFiles(std::unique_ptr<DiveSource> source) : source_(std::move(source)) {
    std::vector<std::string> paths;
    paths.reserve(source_->files().size());
    for (const SourceFile& file : source_->files())
        if (!is_left_by_desktop(file.path)) paths.push_back(file.path);
    const auto root = find_dive_root(paths);
    if (!root) refuse(source_->unused_links());
    for (const std::string& path : paths)
        if (auto folder = folder_of_dive(path); folder && *folder != root->strip)
            other_dives_.push_back(std::move(*folder));
    std::sort(other_dives_.begin(), other_dives_.end());
    for (const SourceFile& file : source_->files()) {
        auto& entries = is_left_by_desktop(file.path) ? left_by_desktop_ : entries_;
        if (auto path = path_in_dive(*root, file.path))
            entries.push_back({std::move(*path), &file});
    }
    std::sort(entries_.begin(), entries_.end(), [](const Entry& a, const Entry& b) {
        return a.path < b.path;
    });
}

const SourceFile* DiveFiles::find(std::string_view path) const {
    const auto entry = std::lower_bound(
        entries_.begin(), entries_.end(), path, [](const Entry& candidate, std::string_view key) {
            return candidate.path < key;
        });
    return entry != entries_.end() && entry->path == path ? entry->file : nullptr;
}

std::int64_t DiveFiles::size_bytes(std::string_view path) const {
    const SourceFile* file = find(path);
    return file != nullptr ? file->size_bytes : 0;
}

std::optional<std::string> DiveFiles::read(std::string_view path, std::int64_t max_bytes) const {
    const SourceFile* file = find(path);
    if (file == nullptr || file->size_bytes > max_bytes) return std::nullopt;
    std::string bytes;
    bytes.reserve(static_cast<std::size_t>(file->size_bytes));
    source_->read(*file,
                  [&](std::span<const char> chunk) { bytes.append(chunk.data(), chunk.size()); });
    return bytes;
}

std::vector<std::string> DiveFiles::sensors() const {
    constexpr std::string_view kRoot = "mav0/";
    std::vector<std::string> names;
    for (const Entry& entry : entries_) {
        const std::string_view path = entry.path;
        const std::size_t slash = path.find('/', kRoot.size());
        if (!path.starts_with(kRoot) || slash == std::string_view::npos) continue;
        const std::string_view name = path.substr(kRoot.size(), slash - kRoot.size());
        if (names.empty() || names.back() != name) names.emplace_back(name);
    }
    return names;
}

std::vector<std::string> DiveFiles::names_in(std::string_view folder) const {
    std::vector<std::string> names;
    for (const Entry& entry : entries_) {
        if (!entry.path.starts_with(folder)) continue;
        const std::string name = entry.path.substr(folder.size());
        if (name.find('/') == std::string::npos) names.push_back(name);
    }
    return names;
}

ContentHash DiveFiles::content_hash(const base::ProgressCallback& progress) const {
    std::vector<Entry> entries = entries_;
    entries.insert(entries.end(), left_by_desktop_.begin(), left_by_desktop_.end());
    std::int64_t total_bytes = 1;
    for (const Entry& entry : entries) total_bytes += entry.file->size_bytes;
    std::int64_t done_bytes = 0;
    std::vector<HashedFile> hashed;
    hashed.reserve(entries.size());
    for (const Entry& entry : entries) {
        std::string sha256 = entry.file->sha256;
        if (sha256.empty()) {
            Sha256 hash;
            source_->read(*entry.file, [&](std::span<const char> chunk) {
                hash.update(chunk);
                done_bytes += std::ssize(chunk);
                Progress state;
                state.fraction = static_cast<double>(done_bytes) / static_cast<double>(total_bytes);
                progress(state);
            });
            sha256 = hash.hex();
        }
        hashed.push_back({entry.path, std::move(sha256)});
    }
    return divemesh::content_hash(hashed);
}

}  // namespace divemesh::dive
