#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "worker/base/observer.hpp"
#include "worker/dive/dive_source.hpp"
#include "worker/dive/finding_log.hpp"

namespace divemesh::recording {

// The largest image file that is read: 64 megapixels in colour of 16 bits.
inline constexpr std::int64_t kMaxStill_bytes = std::int64_t{512} << 20U;

// Returns whether a name is that of an image of a format that is read, by its extension.
bool is_image_name(std::string_view name);

// Returns whether a system put a file there: a part of its name begins with a point, or macOS's
// folder of resource forks.
bool is_of_system(std::string_view name);

// Returns whether a path is a folder that is no ROS 2 bag: no .db3 or .mcap file lies directly in
// it.
bool is_image_folder(const std::filesystem::path& path);

// The files of a recording that is one folder or archive, or two: one for each camera. Those of the
// first are named "left/..." then, those of the second "right/...". Names are only names: files are
// opened below their folder, those of archives are in one unlinked file in `scratch`.
class ImageFolders {
public:
    // Lists the folders. Throws as dive::open_source() does.
    ImageFolders(const std::vector<std::filesystem::path>& folders,
                 const std::filesystem::path& scratch,
                 dive::FindingLog& findings,
                 const base::ProgressCallback& progress,
                 Links links = Links::LeaveOut);

    // Returns the names of all files but those that systems and programs put beside images
    // (".DS_Store", "._x", "__MACOSX/"), sorted.
    const std::vector<std::string>& names() const { return names_; }
    // Returns those of images of a format that is read, by their extension, sorted.
    const std::vector<std::string>& images() const { return images_; }
    bool has(std::string_view name) const { return find(name) != nullptr; }
    // Throws Error{NotFound} if there is no such file.
    std::int64_t size_bytes(std::string_view name) const { return at(name).file->size_bytes; }
    // Returns the nearest file of one of these names, in the folder of an image or those above it;
    // "" if there is none.
    std::string nearest(std::string_view image, std::span<const char* const> file_names) const;
    // Returns the bytes of a file, or the first of them. Throws Error{BadData} if there are more
    // than `max_bytes`, Error{NotFound} if there is no such file, and as dive::DiveSource does.
    std::string read(std::string_view name, std::int64_t max_bytes) const;
    // Passes the bytes of a file to `sink`, in chunks.
    void read_all(std::string_view name, const dive::DiveSource::Sink& sink) const;
    std::string read_head(std::string_view name, std::int64_t num_bytes) const;

private:
    struct Place {
        std::string name;
        std::size_t folder = 0;
        const dive::SourceFile* file = nullptr;
    };
    const Place* find(std::string_view name) const;
    const Place& at(std::string_view name) const;
    std::string read_first(const Place& place, std::int64_t num_bytes) const;
    void add(std::size_t folder, const std::string& prefix);
    void report_unread_formats(dive::FindingLog& findings) const;

    std::vector<std::unique_ptr<dive::DiveSource>> sources_;
    std::vector<Place> places_;  // sorted by name
    std::vector<std::string> names_;
    std::vector<std::string> images_;
};

// Returns a text with the letters A to Z in lower case.
std::string lower_case(std::string_view text);

// Returns the folder of a file, with the slash at its end; "" for a file of the root.
std::string_view folder_of(std::string_view name);

// Returns the name of a file without its folder and extension.
std::string_view stem_of(std::string_view name);

}  // namespace divemesh::recording
