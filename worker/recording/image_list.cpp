#include "worker/recording/image_list.hpp"

#include <algorithm>
#include <set>
#include <unordered_map>

#include "worker/dive/csv.hpp"
#include "worker/recording/image_folders.hpp"
#include "worker/recording/name_numbers.hpp"

namespace divemesh::recording {
namespace {

// Returns a path in small letters with a slash in front, so that ends are whole names.
std::string with_slash(std::string_view path) {
    std::string text(1, '/');
    text += lower_case(path);
    return text;
}

// The images of a camera by their own names, in lower case and without extensions.
class ImagesByName {
public:
    explicit ImagesByName(const std::vector<SidedImage>& images) : images_(images) {
        for (std::size_t i = 0; i < images.size(); ++i)
            places_.emplace(lower_case(stem_of(images[i].name)), i);
    }

    // Returns the image whose name and folders are those of a path, as far as both have them.
    const SidedImage* find_by_path(std::string_view path) const {
        const std::string wanted = with_slash(path);
        const auto [begin, end] = places_.equal_range(key(path));
        for (auto place = begin; place != end; ++place) {
            const SidedImage& image = images_[place->second];
            const std::string folders = with_slash(folder_of(image.name));
            const std::string wanted_folders(folder_of(wanted));
            if (folders.ends_with(wanted_folders) || wanted_folders.ends_with(folders))
                return &image;
        }
        return nullptr;
    }
    // Returns the only image of a path's last part, whatever its folder.
    const SidedImage* find_by_file(std::string_view path) const {
        const auto [begin, end] = places_.equal_range(key(path));
        const bool is_one = begin != end && std::next(begin) == end;
        return is_one ? &images_[begin->second] : nullptr;
    }

private:
    // A name in a table may lack the extension, and then a decimal point in it is none of one.
    std::string key(std::string_view path) const {
        const std::string file = lower_case(path.substr(folder_of(path).size()));
        return places_.contains(file) ? file : std::string(stem_of(file));
    }

    const std::vector<SidedImage>& images_;
    std::unordered_multimap<std::string, std::size_t> places_;
};

std::string with_slashes(std::string_view path) {
    std::string text(path);
    std::replace(text.begin(), text.end(), '\\', '/');
    return text;
}

using Fields = std::span<const std::string_view>;

class TableReader {
public:
    explicit TableReader(const CameraSides& sides)
        : sides_(sides), left_(sides.left), right_(sides.right) {}

    ListedImages read(const TimeTable& table) {
        dive::for_each_csv_row(table.csv, [&](std::int64_t, Fields fields) {
            const auto time_ns = dive::parse_integer(fields[0]);
            if (!time_ns) return;
            times_ns_.push_back(*time_ns);
            take_names(*time_ns, fields.subspan(1));
        });
        if (taken_.empty()) return {in_order(sides_.left), in_order(sides_.right)};
        return std::move(listed_);
    }

private:
    void take_names(std::int64_t time_ns, Fields fields) {
        const SidedImage* left = nullptr;
        const SidedImage* right = nullptr;
        for (const std::string_view field : fields) {
            const std::string path = with_slashes(field);
            if (left == nullptr) left = left_.find_by_path(path);
            if (right == nullptr) right = right_.find_by_path(path);
        }
        if (left == nullptr && right == nullptr) {
            // Folders of another machine tell nothing: then the left image comes first.
            for (const std::string_view field : fields) {
                const std::string path = with_slashes(field);
                if (left == nullptr) left = left_.find_by_file(path);
                if (const auto* found = right_.find_by_file(path)) right = found;
            }
        }
        add(listed_.left, time_ns, left);
        add(listed_.right, time_ns, right);
    }

    void add(std::vector<dive::CameraRow>& rows, std::int64_t time_ns, const SidedImage* image) {
        if (image != nullptr && taken_.insert(image).second) rows.push_back({time_ns, image->name});
    }

    // Returns the images with the times of a table that has no names of them.
    std::vector<dive::CameraRow> in_order(const std::vector<SidedImage>& images) const {
        std::vector<dive::CameraRow> rows;
        for (std::size_t i = 0; i < images.size(); ++i) {
            const auto number = dive::parse_integer(last_number(images[i].stem));
            const bool is_counted = images.size() != times_ns_.size();
            const auto row = is_counted ? number.value_or(-1) : static_cast<std::int64_t>(i);
            if (row < 0 || row >= std::ssize(times_ns_)) return {};
            rows.push_back({times_ns_[static_cast<std::size_t>(row)], images[i].name});
        }
        return rows;
    }

    const CameraSides& sides_;
    ImagesByName left_;
    ImagesByName right_;
    std::vector<std::int64_t> times_ns_;
    std::set<const SidedImage*> taken_;
    ListedImages listed_;
};

}  // namespace

ListedImages images_of_table(const TimeTable& table, const CameraSides& sides) {
    return TableReader(sides).read(table);
}

}  // namespace divemesh::recording
