#pragma once

#include <cstdint>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string_view>

#include "worker/base/atomic_file.hpp"

namespace divemesh::io {

// A glTF binary that is written part by part: its buffer first, which lies in a file beside the
// final one until its description is known. Throws as AtomicFile does, and Error{TooLarge} beyond
// the 4 GiB of the format.
class GlbFile {
public:
    explicit GlbFile(const std::filesystem::path& file);
    ~GlbFile();
    GlbFile(const GlbFile&) = delete;
    GlbFile& operator=(const GlbFile&) = delete;

    // Appends bytes to the buffer at a multiple of 4. Returns where they begin.
    std::uint64_t add(std::string_view bytes);
    std::uint64_t size_bytes() const { return size_bytes_; }  // of the buffer

    // Writes header, JSON chunk and binary chunk (glTF 2.0, section 4.4).
    void commit(const nlohmann::json& document);

private:
    void check_size(std::uint64_t size_bytes) const;

    std::filesystem::path file_;
    std::filesystem::path buffer_file_;
    base::AtomicFile buffer_;
    std::uint64_t size_bytes_ = 0;
};

}  // namespace divemesh::io
