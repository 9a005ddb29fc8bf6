#include "storage/page_cursor.hpp"

#include <algorithm>
#include <charconv>
#include <limits>

#include "schemas/error.hpp"

namespace divemesh::storage {
namespace {

constexpr int kMaxLimit = 200;

bool is_id(std::string_view text) {
    return !text.empty() && text.size() <= 64 && std::all_of(text.begin(), text.end(), [](char c) {
        return (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '_';
    });
}

}  // namespace

PageStart page_start(const PageRequest& page) {
    if (page.limit < 1 || page.limit > kMaxLimit)
        throw Error(
            ErrorCode::InvalidArgument,
            "limit is " + std::to_string(page.limit) + ": give 1 to " + std::to_string(kMaxLimit));
    PageStart start;
    start.limit_plus_one = page.limit + 1;
    if (page.newest_first) {
        start.created_at_ms = std::numeric_limits<std::int64_t>::max();
        start.condition = "(created_at_ms < :age OR (created_at_ms = :age AND id < :id))";
        start.order = "created_at_ms DESC, id DESC";
    }
    if (page.cursor.empty()) return start;

    const auto dot = std::min(page.cursor.find('.'), page.cursor.size());
    const char* end = page.cursor.data() + dot;
    const auto [stopped, failure] = std::from_chars(page.cursor.data(), end, start.created_at_ms);
    if (dot < page.cursor.size()) start.id = page.cursor.substr(dot + 1);
    if (failure != std::errc() || stopped != end || start.created_at_ms < 0 || !is_id(start.id))
        throw Error(
            ErrorCode::InvalidArgument,
            "this is not a cursor of this list: give next_cursor of the previous page unchanged");
    return start;
}

std::string cursor_after(std::int64_t created_at_ms, const std::string& id) {
    return std::to_string(created_at_ms) + "." + id;
}

}  // namespace divemesh::storage
