#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <span>
#include <string>
#include <string_view>
#include <sys/types.h>

namespace divemesh::sensor {

// A growing data.csv: reads the rows that are new since the last call. A line without its end is
// left for later; a file that was replaced or truncated is read from its beginning.
class TableTail {
public:
    // The first field is a time stamp; rows without one are skipped.
    using OnRow =
        std::function<void(std::int64_t timestamp_ns, std::span<const std::string_view> fields)>;

    explicit TableTail(std::filesystem::path file) : file_(std::move(file)) {}

    // Reads new rows in order, up to the first that is stamped after `until_ns`; a few megabytes at
    // most. Returns false if the file is missing or unreadable.
    bool read(std::int64_t until_ns, const OnRow& on_row);

private:
    bool fetch();  // false: at the end of the file
    bool take_row(std::int64_t until_ns, const OnRow& on_row);

    std::filesystem::path file_;
    ino_t inode_ = 0;
    std::int64_t offset_ = 0;
    std::string pending_;       // read, but not yet passed on
    std::size_t returned_ = 0;  // how much of it was passed on
    bool is_there_ = false;
};

}  // namespace divemesh::sensor
