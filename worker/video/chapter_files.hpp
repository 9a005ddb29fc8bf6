#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace divemesh::video {

// The files of a recording that a GoPro split into chapters, as they lie beside one of them. Names
// are GX010123.MP4, GX020123.MP4 ..., the same with GH, or GOPR0123.MP4, GP010123.MP4 ...
struct ChapterFiles {
    std::vector<std::filesystem::path> files;  // the given one and those that follow, without a gap
    std::vector<std::string> earlier;          // names before the given one, which is alone then
    std::string missing;                       // name of the first chapter of a gap; "": none
    std::vector<std::string> after_gap;        // names that follow it
};

// Returns the chapters of a video; the given file alone if its name is not that of a chapter.
ChapterFiles find_chapters(const std::filesystem::path& video);

// Returns whether two files in one folder are different chapters of the same recording.
bool are_chapters_of_one(const std::filesystem::path& a, const std::filesystem::path& b);

}  // namespace divemesh::video
