#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>

#include "worker/base/atomic_file.hpp"

namespace divemesh::io {

// A file in the pages of E57 (ASTM E2807, 5.2): 1020 bytes of content and their CRC-32C, the most
// significant byte first. Logical offsets count content alone, physical ones all. Throws as
// AtomicFile does.
class E57Pages {
public:
    static constexpr std::uint64_t kPage_bytes = 1024;

    explicit E57Pages(const std::filesystem::path& file) : output_(file) {}

    static std::uint64_t physical(std::uint64_t logical);
    // Returns the length of a file with as much content.
    static std::uint64_t file_length(std::uint64_t content_bytes);

    void write(std::string_view content);
    void commit();  // fills the last page with zeros; the file does not exist before

private:
    void write_page();

    base::AtomicFile output_;
    std::string page_;
};

}  // namespace divemesh::io
