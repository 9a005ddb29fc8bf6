#include "worker/dive/image_names.hpp"

#include <algorithm>
#include <map>
#include <optional>
#include <utility>

#include "worker/dive/csv.hpp"
#include "worker/dive/entry_name.hpp"
#include "worker/dive/stamp_check.hpp"

namespace divemesh::dive {
namespace {

constexpr const char* kExtensions[] = {".png", ".jpg", ".jpeg", ".bmp", ".tif", ".tiff", ".webp"};
constexpr std::int64_t kMinTimestamp_ns = 1'000'000'000;  // smaller names are counters

std::string lower(std::string text) {
    std::transform(text.begin(), text.end(), text.begin(), [](unsigned char c) {
        return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : static_cast<char>(c);
    });
    return text;
}

bool is_image(const std::string& name) {
    return std::any_of(std::begin(kExtensions), std::end(kExtensions), [&](const char* extension) {
        return lower(name).ends_with(extension);
    });
}

// Returns the last part of a path in lower case without the extension of an image.
std::string stem(const std::string& path) {
    const std::string all = lower(path.substr(path.rfind('/') + 1));
    return is_image(all) ? all.substr(0, all.rfind('.')) : all;
}

// The images of a folder by their stems; those whose stem is not their own are left out.
class ImagesByStem {
public:
    ImagesByStem(const DiveFiles& files, std::string folder) : folder_(std::move(folder)) {
        for (const std::string& name : files.names_in(folder_)) {
            if (!is_image(name)) continue;
            const auto [place, is_new] = names_.try_emplace(stem(name), name);
            if (!is_new) place->second.clear();
        }
    }
    std::optional<std::string> find(const std::string& path) const {
        const auto place = names_.find(stem(path));
        if (place == names_.end() || place->second.empty()) return std::nullopt;
        return folder_ + place->second;
    }

private:
    std::string folder_;
    std::map<std::string, std::string> names_;
};

}  // namespace

void complete_image_names(std::vector<CameraRow>& rows,
                          const DiveFiles& files,
                          const std::string& camera,
                          FindingLog& findings) {
    const auto is_there = [&](const CameraRow& row) { return files.has(row.file); };
    if (std::all_of(rows.begin(), rows.end(), is_there)) return;
    const std::string folder = "mav0/" + camera + "/data";
    const ImagesByStem images(files, folder + "/");
    std::int64_t num_completed = 0;
    std::string example;
    for (CameraRow& row : rows) {
        if (is_there(row)) continue;
        const auto found = images.find(row.file);
        if (!found) continue;
        if (num_completed++ == 0) example = *found;
        row.file = *found;
    }
    if (num_completed == 0) return;
    findings.warning("image_names_completed",
                     "mav0/" + camera + "/data.csv",
                     std::to_string(num_completed) + " of " + std::to_string(rows.size()) +
                         " rows give image names whose folder, extension or case differs from the "
                         "files'; the files are used, such as " +
                         printable(example),
                     "Write in column 2 the whole file name of the image, as in " + folder + ".");
}

std::vector<CameraRow> rows_by_image_names(const DiveFiles& files,
                                           const std::string& camera,
                                           FindingLog& findings) {
    const std::string folder = "mav0/" + camera + "/data/";
    std::vector<CameraRow> rows;
    for (const std::string& name : files.names_in(folder)) {
        const auto stamp = parse_integer(name.substr(0, name.find('.')));
        if (is_image(name) && stamp && *stamp >= kMinTimestamp_ns && *stamp <= kMaxTimestamp_ns)
            rows.push_back({*stamp, folder + name});
    }
    std::sort(rows.begin(), rows.end(), [](const CameraRow& a, const CameraRow& b) {
        return a.timestamp_ns < b.timestamp_ns;
    });
    const auto last = std::unique(rows.begin(), rows.end(), [](const auto& a, const auto& b) {
        return a.timestamp_ns == b.timestamp_ns;
    });
    rows.erase(last, rows.end());
    if (!rows.empty())
        findings.warning("image_list_missing",
                         "mav0/" + camera + "/data.csv",
                         "no image is listed there; " + std::to_string(rows.size()) +
                             " images are used whose names are timestamps in nanoseconds",
                         "Write the list of images there: timestamp [ns],filename.");
    return rows;
}

}  // namespace divemesh::dive
