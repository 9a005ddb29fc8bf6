#include "worker/recording/image_times.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <set>
#include <utility>

#include "schemas/error.hpp"
#include "worker/dive/csv.hpp"
#include "worker/dive/entry_name.hpp"
#include "worker/dive/stamp_check.hpp"
#include "worker/recording/exif_time.hpp"
#include "worker/recording/image_list.hpp"
#include "worker/recording/input_file.hpp"
#include "worker/recording/name_numbers.hpp"
#include "worker/recording/time_table.hpp"

namespace divemesh::recording {
namespace {

using Rows = std::vector<dive::CameraRow>;

constexpr std::int64_t kSecond_ns = 1'000'000'000;
constexpr std::int64_t kMaxList_bytes = std::int64_t{32} << 20U;  // 400,000 rows of 80 bytes
constexpr std::int64_t kHead_bytes = std::int64_t{256} << 10U;    // EXIF is in the first 64 KiB
constexpr double kMinRate_hz = 1e-4;
constexpr double kMaxRate_hz = 1000.0;
constexpr std::array kListNames = {"data.csv",
                                   "timestamps.txt",
                                   "timestamps.csv",
                                   "timestamp.txt",
                                   "times.txt",
                                   "times.csv",
                                   "images.csv",
                                   "images.txt"};

void sort_rows(Rows& rows) {
    std::sort(rows.begin(), rows.end(), [](const dive::CameraRow& a, const dive::CameraRow& b) {
        return std::pair(a.timestamp_ns, a.file) < std::pair(b.timestamp_ns, b.file);
    });
}

// Spreads images of one whole second evenly over it, in the order of their names.
void spread_over_seconds(Rows& rows) {
    for (std::size_t first = 0; first < rows.size();) {
        std::size_t end = first + 1;
        while (end < rows.size() && rows[end].timestamp_ns == rows[first].timestamp_ns) ++end;
        const auto num_images = static_cast<std::int64_t>(end - first);
        for (std::size_t i = first; i < end; ++i)
            rows[i].timestamp_ns += static_cast<std::int64_t>(i - first) * kSecond_ns / num_images;
        first = end;
    }
}

// Returns whether most rows have a time of their own; spreadsheets round times of 19 digits.
bool are_distinct(const Rows& rows) {
    std::set<std::int64_t> times_ns;
    for (const dive::CameraRow& row : rows) times_ns.insert(row.timestamp_ns);
    return times_ns.size() * 2 >= rows.size();
}

class TimeFinder {
public:
    TimeFinder(const ImageFolders& folders,
               const CameraSides& sides,
               const TimeOptions& options,
               dive::FindingLog& findings,
               const base::ProgressCallback& progress)
        : folders_(folders),
          sides_(sides),
          options_(options),
          findings_(findings),
          progress_(progress) {}

    ImageTimes find() {
        ImageTimes times = first_found();
        report_untimed(sides_.left.size() - times.left.size(), "left", times.source);
        report_untimed(sides_.right.size() - times.right.size(), "right", times.source);
        for (Rows* rows : {&times.left, &times.right}) {
            sort_rows(*rows);
            if (times.is_in_seconds) spread_over_seconds(*rows);
        }
        return times;
    }

private:
    ImageTimes first_found() {
        if (!options_.list.empty()) return by_stated_list();
        if (options_.rate_hz) return by_counting();
        if (auto times = by_list_beside()) return *times;
        if (auto times = by_names()) return *times;
        if (auto times = by_exif()) return *times;
        throw Error(ErrorCode::InvalidArgument,
                    "neither a list nor the names nor the EXIF of the images state when they were "
                    "taken: give a table of times and names by --list, or the images per second by "
                    "--rate; if the names hold times, give their unit by --unit");
    }

    ImageTimes by_stated_list() {
        const InputFile file(options_.list);
        if (file.size_bytes() > kMaxList_bytes)
            throw Error(ErrorCode::BadData, options_.list.string() + " is larger than 32 MiB");
        const auto table = convert_time_table(file.read(0, kMaxList_bytes), options_.unit);
        if (!table)
            throw Error(ErrorCode::BadData,
                        options_.list.string() +
                            " has no column of times: write the time, the left and the right image "
                            "in each row, and give the unit of the times by --unit");
        ListedImages listed = images_of_table(*table, sides_);
        if (listed.left.empty() || listed.right.empty())
            throw Error(ErrorCode::BadData,
                        options_.list.string() + " names no image of the " +
                            (listed.left.empty() ? "left" : "right") +
                            " camera: write the time, the left and the right image in each row");
        return of_tables(std::move(listed),
                         options_.list.filename().string(),
                         table->unit,
                         !table->has_fraction);
    }

    static ImageTimes of_tables(ListedImages listed,
                                const std::string& name,
                                const std::string& unit,
                                bool is_in_seconds) {
        std::string source = "the times in " + dive::printable(name) + " (" + unit + ")";
        return {std::move(listed.left), std::move(listed.right), std::move(source), is_in_seconds};
    }

    std::optional<ImageTimes> by_list_beside() {
        const std::string left_list = folders_.nearest(sides_.left.front().name, kListNames);
        const std::string right_list = folders_.nearest(sides_.right.front().name, kListNames);
        if (left_list.empty() || right_list.empty()) return std::nullopt;
        const auto left_table = table_of(left_list);
        const auto right_table = left_list == right_list ? left_table : table_of(right_list);
        if (!left_table || !right_table) return std::nullopt;
        ListedImages listed = images_of_table(*left_table, sides_);
        if (left_list != right_list) listed.right = images_of_table(*right_table, sides_).right;
        if (listed.left.empty() || listed.right.empty()) {
            report_unusable(listed.left.empty() ? left_list : right_list,
                            "it does not name the images, nor has a row for each of them");
            return std::nullopt;
        }
        if (!are_distinct(listed.left) && left_table->has_fraction) {
            report_unusable(left_list, "most of its times are the same, as if they were rounded");
            return std::nullopt;
        }
        return of_tables(std::move(listed),
                         left_list,
                         left_table->unit,
                         !left_table->has_fraction || !right_table->has_fraction);
    }

    std::optional<TimeTable> table_of(const std::string& list) {
        const std::string text = folders_.read(list, kMaxList_bytes);
        auto table = convert_time_table(text, options_.unit);
        if (!table) report_unusable(list, "no column of it is a time of a known unit");
        return table;
    }

    void report_unusable(const std::string& list, const std::string& why) {
        findings_.warning("image_list_unusable",
                          dive::printable(list),
                          "the list is not used: " + why,
                          "Write the time and the name of the image in each row, and give the unit "
                          "of the times by --unit.");
    }

    std::optional<ImageTimes> by_names() const {
        std::vector<std::string> numbers;
        for (const auto* images : {&sides_.left, &sides_.right})
            for (const SidedImage& image : *images) numbers.push_back(longest_number(image.stem));
        const auto unit = options_.unit ? options_.unit : unit_of_stamps(numbers);
        if (!unit) return std::nullopt;
        ImageTimes times;
        times.source = std::string("the times in their names (") + name_of(*unit) + ")";
        std::size_t next = 0;
        bool has_fraction = false;
        for (const auto& [images, rows] :
             {std::pair(&sides_.left, &times.left), std::pair(&sides_.right, &times.right)})
            for (const SidedImage& image : *images) {
                const auto time_ns = parse_stamp(numbers[next++], *unit);
                if (!time_ns) return std::nullopt;
                has_fraction = has_fraction || *time_ns % kSecond_ns != 0;
                rows->push_back({*time_ns, image.name});
            }
        times.is_in_seconds = *unit == StampUnit::Seconds && !has_fraction;
        return times;
    }

    std::optional<ImageTimes> by_exif() {
        ImageTimes times;
        times.source = "the times in their EXIF";
        times.is_in_seconds = true;
        for (const auto& [images, rows] :
             {std::pair(&sides_.left, &times.left), std::pair(&sides_.right, &times.right)}) {
            for (const SidedImage& image : *images) {
                progress_({"read times"});
                const auto time = exif_time(head_of(image.name));
                if (!time) continue;
                times.is_in_seconds = times.is_in_seconds && !time->has_fraction;
                rows->push_back({time->timestamp_ns, image.name});
            }
            if (rows->size() * 2 < images->size() || rows->empty()) return std::nullopt;
        }
        return times;
    }

    // Returns what may hold EXIF: the first bytes of a JPEG or PNG, all of a TIFF.
    std::string head_of(const std::string& image) const {
        const bool is_tiff =
            lower_case(image).ends_with(".tif") || lower_case(image).ends_with(".tiff");
        return folders_.read_head(image, is_tiff ? kMaxStill_bytes : kHead_bytes);
    }

    ImageTimes by_counting() {
        const double rate_hz = *options_.rate_hz;
        if (!(rate_hz >= kMinRate_hz && rate_hz <= kMaxRate_hz))
            throw Error(ErrorCode::InvalidArgument,
                        "--rate has to be from 0.0001 to 1000 images a second");
        const auto left = counters_of(sides_.left);
        const auto right = counters_of(sides_.right);
        const bool are_counted = !left.empty() && !right.empty();
        ImageTimes times;
        times.source = are_counted ? "the counters in their names" : "the order of their names";
        const std::int64_t first = are_counted
                                       ? std::min(*std::min_element(left.begin(), left.end()),
                                                  *std::min_element(right.begin(), right.end()))
                                       : 0;
        const auto add =
            [&](const std::vector<SidedImage>& images, const auto& counters, Rows& rows) {
                for (std::size_t i = 0; i < images.size(); ++i) {
                    const std::int64_t count =
                        are_counted ? counters[i] - first : static_cast<std::int64_t>(i);
                    rows.push_back({time_of_count(count, rate_hz), images[i].name});
                }
            };
        add(sides_.left, left, times.left);
        add(sides_.right, right, times.right);
        return times;
    }

    static std::int64_t time_of_count(std::int64_t count, double rate_hz) {
        const double time_ns = std::round(static_cast<double>(count) / rate_hz * 1e9);
        if (time_ns > static_cast<double>(dive::kMaxTimestamp_ns))
            throw Error(ErrorCode::InvalidArgument,
                        "the numbers in the names are too far apart to count images: give a list "
                        "by --list");
        return static_cast<std::int64_t>(time_ns);
    }

    // Returns the last numbers of the names; empty if one has none or two have the same.
    static std::vector<std::int64_t> counters_of(const std::vector<SidedImage>& images) {
        std::vector<std::int64_t> counters;
        std::set<std::int64_t> seen;
        for (const SidedImage& image : images) {
            const auto counter = dive::parse_integer(last_number(image.stem));
            if (!counter || !seen.insert(*counter).second) return {};
            counters.push_back(*counter);
        }
        return counters;
    }

    void report_untimed(std::size_t num_images, const char* side, const std::string& source) {
        if (num_images == 0) return;
        findings_.warning("image_untimed",
                          "",
                          std::to_string(num_images) + " images of the " + side +
                              " camera are left out: " + source +
                              " do not say when they were taken",
                          "Give a table of times and names by --list.");
    }

    const ImageFolders& folders_;
    const CameraSides& sides_;
    const TimeOptions& options_;
    dive::FindingLog& findings_;
    const base::ProgressCallback& progress_;
};

}  // namespace

ImageTimes find_image_times(const ImageFolders& folders,
                            const CameraSides& sides,
                            const TimeOptions& options,
                            dive::FindingLog& findings,
                            const base::ProgressCallback& progress) {
    return TimeFinder(folders, sides, options, findings, progress).find();
}

}  // namespace divemesh::recording
