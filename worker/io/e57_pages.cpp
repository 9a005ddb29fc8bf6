#include "worker/io/e57_pages.hpp"

#include <algorithm>

#include "worker/io/crc32.hpp"

namespace divemesh::io {
namespace {

constexpr std::uint64_t kContent_bytes = E57Pages::kPage_bytes - sizeof(std::uint32_t);

}  // namespace

std::uint64_t E57Pages::physical(std::uint64_t logical) {
    return logical / kContent_bytes * kPage_bytes + logical % kContent_bytes;
}

std::uint64_t E57Pages::file_length(std::uint64_t content_bytes) {
    return (content_bytes + kContent_bytes - 1) / kContent_bytes * kPage_bytes;
}

void E57Pages::write(std::string_view content) {
    while (!content.empty()) {
        const std::size_t num =
            std::min<std::size_t>(content.size(), kContent_bytes - page_.size());
        page_ += content.substr(0, num);
        content.remove_prefix(num);
        if (page_.size() == kContent_bytes) write_page();
    }
}

void E57Pages::commit() {
    if (!page_.empty()) {
        page_.resize(kContent_bytes, '\0');
        write_page();
    }
    output_.commit();
}

void E57Pages::write_page() {
    Crc32c crc;
    crc.add(page_);
    for (const unsigned shift : {24U, 16U, 8U, 0U})
        page_ += static_cast<char>(crc.value() >> shift & 0xffU);
    output_.write(page_);
    page_.clear();
}

}  // namespace divemesh::io
