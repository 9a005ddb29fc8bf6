#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <span>
#include <string>
#include <string_view>
#include <sys/types.h>

namespace divemesh::sensor {

// A data.csv that grows: the rows that have come since it was looked at last. A line without its
// end is left for later; a file that was replaced or cut begins anew.
class TableTail {
public:
    // The first field is a time stamp; rows without one are left out.
    using OnRow =
        std::function<void(std::int64_t timestamp_ns, std::span<const std::string_view> fields)>;

    explicit TableTail(std::filesystem::path file) : file_(std::move(file)) {}

    // New rows in their order, up to the first that is stamped after `until_ns`; a few megabytes at
    // most. False: the file is not there, or cannot be read.
    bool read(std::int64_t until_ns, const OnRow& on_row);

private:
    bool fetch();  // false: there is no more
    bool take_row(std::int64_t until_ns, const OnRow& on_row);

    std::filesystem::path file_;
    ino_t inode_ = 0;
    std::int64_t offset_ = 0;
    std::string pending_;       // read and not told yet
    std::size_t returned_ = 0;  // of it
    bool is_there_ = false;
};

}  // namespace divemesh::sensor
