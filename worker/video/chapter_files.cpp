#include "worker/video/chapter_files.hpp"

#include <algorithm>
#include <cctype>
#include <map>
#include <optional>
#include <tuple>

namespace divemesh::video {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kName_chars = 8;  // without the extension

// What the name of a chapter states. Letters are large ones.
struct ChapterName {
    std::string family;  // "GX", "GH" or "GP"; GOPR0123 is chapter 0 of GP
    int chapter = 0;
    std::string recording;  // "0123"
    std::string extension;

    bool is_beside(const ChapterName& other) const {
        return std::tie(family, recording, extension) ==
               std::tie(other.family, other.recording, other.extension);
    }
};

std::string upper(std::string text) {
    for (char& letter : text)
        letter = static_cast<char>(std::toupper(static_cast<unsigned char>(letter)));
    return text;
}

bool are_digits(const std::string& text) {
    return std::all_of(
        text.begin(), text.end(), [](char letter) { return letter >= '0' && letter <= '9'; });
}

std::optional<ChapterName> chapter_name(const fs::path& file) {
    const std::string stem = upper(file.stem().string());
    if (stem.size() != kName_chars || !are_digits(stem.substr(4))) return std::nullopt;
    ChapterName name{stem.substr(0, 2), 0, stem.substr(4), upper(file.extension().string())};
    if (stem.starts_with("GOPR")) {
        name.family = "GP";
        return name;
    }
    const std::string chapter = stem.substr(2, 2);
    const bool is_known = name.family == "GX" || name.family == "GH" || name.family == "GP";
    if (!is_known || !are_digits(chapter) || chapter == "00") return std::nullopt;
    name.chapter = std::stoi(chapter);
    return name;
}

// Returns the name of another chapter, as the camera writes it.
std::string name_of(const ChapterName& name, int chapter) {
    std::string text = name.family;
    if (chapter < 10) text += '0';
    return text + std::to_string(chapter) + name.recording + name.extension;
}

// Returns the files beside a video that are of the same recording, by their chapter. Of names that
// differ by small letters alone the first is taken.
std::map<int, fs::path> files_beside(const fs::path& video, const ChapterName& name) {
    std::map<int, fs::path> files;
    const fs::path folder = video.has_parent_path() ? video.parent_path() : fs::path(".");
    std::error_code ignored;
    for (fs::directory_iterator entry(folder, ignored), end; !ignored && entry != end;
         entry.increment(ignored)) {
        const auto other = chapter_name(entry->path());
        std::error_code unknown;
        if (!other || !other->is_beside(name) || other->chapter == name.chapter ||
            !entry->is_regular_file(unknown))
            continue;
        const fs::path path = video.parent_path() / entry->path().filename();
        const auto [place, is_new] = files.emplace(other->chapter, path);
        if (!is_new) place->second = std::min(place->second, path);
    }
    return files;
}

}  // namespace

ChapterFiles find_chapters(const fs::path& video) {
    ChapterFiles chapters{{video}, {}, "", {}};
    const auto name = chapter_name(video);
    if (!name) return chapters;
    const auto beside = files_beside(video, *name);
    for (const auto& [chapter, file] : beside)
        if (chapter < name->chapter) chapters.earlier.push_back(file.filename().string());
    if (!chapters.earlier.empty()) return chapters;
    int next = name->chapter + 1;
    for (const auto& [chapter, file] : beside) {
        if (chapter == next) {
            chapters.files.push_back(file);
            ++next;
        } else {
            chapters.after_gap.push_back(file.filename().string());
        }
    }
    if (!chapters.after_gap.empty()) chapters.missing = name_of(*name, next);
    return chapters;
}

bool are_chapters_of_one(const fs::path& a, const fs::path& b) {
    const auto first = chapter_name(a);
    const auto second = chapter_name(b);
    return first && second && first->is_beside(*second) && first->chapter != second->chapter &&
           fs::absolute(a).lexically_normal().parent_path() ==
               fs::absolute(b).lexically_normal().parent_path();
}

}  // namespace divemesh::video
