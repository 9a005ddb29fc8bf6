#include "worker/dive/image_names.hpp"

#include <algorithm>
#include <optional>

#include "worker/dive/csv.hpp"
#include "worker/dive/entry_name.hpp"

namespace divemesh::dive {
namespace {

constexpr const char* kExtensions[] = {
    ".png", ".jpg", ".jpeg", ".PNG", ".JPG", ".JPEG", ".bmp", ".tif", ".tiff", ".webp"};
constexpr std::int64_t kMinTimestamp_ns = 1'000'000'000;  // smaller names are counters
constexpr std::int64_t kMaxTimestamp_ns = 4'000'000'000'000'000'000;

std::optional<std::string> with_extension(const std::string& path, const DiveFiles& files) {
    for (const char* extension : kExtensions)
        if (files.has(path + extension)) return path + extension;
    return std::nullopt;
}

}  // namespace

void complete_image_names(std::vector<CameraRow>& rows,
                          const DiveFiles& files,
                          const std::string& camera,
                          FindingLog& findings) {
    std::int64_t num_completed = 0;
    std::string example;
    for (CameraRow& row : rows) {
        if (files.has(row.file)) continue;
        const auto found = with_extension(row.file, files);
        if (!found) continue;
        if (num_completed++ == 0) example = *found;
        row.file = *found;
    }
    if (num_completed == 0) return;
    findings.warning("image_names_completed",
                     "mav0/" + camera + "/data.csv",
                     std::to_string(num_completed) + " of " + std::to_string(rows.size()) +
                         " rows name images without their extension; files that have one are "
                         "used, such as " +
                         printable(example),
                     "Write in column 2 the whole file name of the image.");
}

std::vector<CameraRow> rows_by_image_names(const DiveFiles& files,
                                           const std::string& camera,
                                           FindingLog& findings) {
    const std::string folder = "mav0/" + camera + "/data/";
    std::vector<CameraRow> rows;
    for (const std::string& name : files.names_in(folder)) {
        const auto stamp = parse_integer(name.substr(0, name.find('.')));
        const bool is_image = std::any_of(std::begin(kExtensions),
                                          std::end(kExtensions),
                                          [&](const char* e) { return name.ends_with(e); });
        if (is_image && stamp && *stamp >= kMinTimestamp_ns && *stamp <= kMaxTimestamp_ns)
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
