#pragma once

#include <cstdint>
#include <string>

#include "storage/page.hpp"

namespace divemesh::storage {

// Where a page begins: after the row with this creation time and id.
struct PageStart {
    std::int64_t created_at_ms = -1;
    std::string id;
    // SQL over created_at_ms and id, with :age and :id for the two above.
    std::string condition = "(created_at_ms > :age OR (created_at_ms = :age AND id > :id))";
    std::string order = "created_at_ms, id";
    int limit_plus_one = 0;  // one row more than requested shows whether there is a next page
};

// Throws Error{InvalidArgument} for a limit out of range or an invalid cursor.
PageStart page_start(const PageRequest& page);

// Returns the cursor of the page after this row.
std::string cursor_after(std::int64_t created_at_ms, const std::string& id);

// Removes the row beyond the limit and sets the cursor of the next page.
template <typename T>
Page<T> make_page(std::vector<T> rows, const PageRequest& request) {
    Page<T> page{.items = std::move(rows)};
    if (page.items.size() <= static_cast<std::size_t>(request.limit)) return page;
    page.items.resize(static_cast<std::size_t>(request.limit));
    page.next_cursor = cursor_after(page.items.back().created_at_ms, page.items.back().id);
    return page;
}

}  // namespace divemesh::storage
