#include "worker/recording/image_folders.hpp"

#include <algorithm>
#include <iterator>

#include "schemas/error.hpp"
#include "worker/dive/dive.hpp"
#include "worker/dive/entry_name.hpp"

namespace divemesh::recording {
namespace {

constexpr const char* kRead[] = {
    ".png", ".jpg", ".jpeg", ".tif", ".tiff", ".bmp", ".pgm", ".ppm", ".pnm"};
constexpr const char* kUnread[] = {
    ".webp", ".heic", ".heif", ".avif", ".dng", ".gpr", ".cr2", ".cr3", ".nef", ".arw", ".raw"};

template <std::size_t kSize>
bool ends_with_one_of(std::string_view name, const char* const (&extensions)[kSize]) {
    const std::string lower = lower_case(name);
    return std::any_of(std::begin(extensions), std::end(extensions), [&](const char* extension) {
        return lower.ends_with(extension);
    });
}

}  // namespace

bool is_image_name(std::string_view name) { return ends_with_one_of(name, kRead); }

bool is_of_system(std::string_view name) {
    for (std::size_t start = 0; start < name.size();) {
        const std::size_t slash = std::min(name.find('/', start), name.size());
        const std::string_view part = name.substr(start, slash - start);
        if (part.starts_with('.') || part == "__MACOSX") return true;
        start = slash + 1;
    }
    return false;
}

bool is_image_folder(const std::filesystem::path& path) {
    std::error_code failure;
    if (!std::filesystem::is_directory(path, failure)) return false;
    for (const auto& entry : std::filesystem::directory_iterator(path, failure)) {
        const std::string name = entry.path().filename().string();
        for (const char* extension : {".db3", ".mcap", ".db3.zstd", ".mcap.zstd"})
            if (name.ends_with(extension)) return false;
    }
    return true;
}

std::string lower_case(std::string_view text) {
    std::string lower(text);
    for (char& c : lower)
        if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
    return lower;
}

std::string_view folder_of(std::string_view name) {
    return name.substr(0, name.rfind('/') + 1);  // 0 where there is none
}

std::string_view stem_of(std::string_view name) {
    name.remove_prefix(folder_of(name).size());
    return name.substr(0, std::min(name.rfind('.'), name.size()));
}

ImageFolders::ImageFolders(const std::vector<std::filesystem::path>& folders,
                           const std::filesystem::path& scratch,
                           dive::FindingLog& findings,
                           const base::ProgressCallback& progress,
                           Links links) {
    dive::DiveLimits limits;
    limits.max_file_bytes = limits.max_unpacked_bytes;  // of a video; read() bounds the others
    for (const std::filesystem::path& folder : folders)
        sources_.push_back(dive::open_source(folder, scratch, limits, progress, findings, links));
    for (std::size_t i = 0; i < sources_.size(); ++i)
        add(i, sources_.size() < 2 ? "" : i == 0 ? "left/" : "right/");
    std::sort(places_.begin(), places_.end(), [](const Place& a, const Place& b) {
        return a.name < b.name;
    });
    for (const Place& place : places_) {
        names_.push_back(place.name);
        if (is_image_name(place.name)) images_.push_back(place.name);
    }
    report_unread_formats(findings);
}

void ImageFolders::add(std::size_t folder, const std::string& prefix) {
    for (const dive::SourceFile& file : sources_[folder]->files())
        if (!is_of_system(file.path)) places_.push_back({prefix + file.path, folder, &file});
}

void ImageFolders::report_unread_formats(dive::FindingLog& findings) const {
    const auto is_unread = [](const std::string& name) { return ends_with_one_of(name, kUnread); };
    const auto first = std::find_if(names_.begin(), names_.end(), is_unread);
    if (first == names_.end()) return;
    findings.warning(
        "images_unread",
        dive::printable(*first),
        std::to_string(std::count_if(names_.begin(), names_.end(), is_unread)) +
            " images are left out, as WebP, HEIF, AVIF and camera raw are not read, such as " +
            dive::printable(*first),
        "Export them as TIFF or PNG.");
}

const ImageFolders::Place* ImageFolders::find(std::string_view name) const {
    const auto place = std::lower_bound(
        places_.begin(), places_.end(), name, [](const Place& candidate, std::string_view key) {
            return candidate.name < key;
        });
    return place != places_.end() && place->name == name ? &*place : nullptr;
}

const ImageFolders::Place& ImageFolders::at(std::string_view name) const {
    if (const Place* place = find(name)) return *place;
    throw Error(ErrorCode::NotFound, "there is no file " + dive::printable(name));
}

std::string ImageFolders::nearest(std::string_view image,
                                  std::span<const char* const> file_names) const {
    std::string folder(folder_of(image));
    while (true) {
        for (const char* name : file_names)
            if (has(folder + name)) return folder + name;
        if (folder.empty()) return "";
        folder.pop_back();
        folder = folder_of(folder);
    }
}

std::string ImageFolders::read(std::string_view name, std::int64_t max_bytes) const {
    const Place& place = at(name);
    if (place.file->size_bytes > max_bytes)
        throw Error(ErrorCode::BadData,
                    dive::printable(name) + " has " + std::to_string(place.file->size_bytes) +
                        " bytes, more than the " + std::to_string(max_bytes) + " allowed");
    return read_first(place, place.file->size_bytes);
}

void ImageFolders::read_all(std::string_view name, const dive::DiveSource::Sink& sink) const {
    const Place& place = at(name);
    sources_[place.folder]->read(*place.file, sink);
}

std::string ImageFolders::read_head(std::string_view name, std::int64_t num_bytes) const {
    const Place& place = at(name);
    return read_first(place, std::min(place.file->size_bytes, num_bytes));
}

std::string ImageFolders::read_first(const Place& place, std::int64_t num_bytes) const {
    dive::SourceFile head = *place.file;
    head.size_bytes = num_bytes;
    std::string bytes;
    bytes.reserve(static_cast<std::size_t>(num_bytes));
    sources_[place.folder]->read(
        head, [&](std::span<const char> chunk) { bytes.append(chunk.data(), chunk.size()); });
    return bytes;
}

}  // namespace divemesh::recording
