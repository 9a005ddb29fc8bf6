#pragma once

#include "api/http.hpp"
#include "api/in_pool.hpp"
#include "api/services.hpp"
#include "schemas/error.hpp"

namespace divemesh::api {

// Reads a few rows by their keys on the caller's own thread, which takes less time than the way to
// the pool and back. If it would have to wait (no connection is idle, or another process holds the
// lock), it reads them in the pool instead. `read` takes the catalog to read from.
template <typename Read>
Awaitable<std::invoke_result_t<Read&, storage::Catalog&>> read_nonblocking(Services services,
                                                                           Read read) {
    try {
        storage::Catalog catalog = services.catalog.read_nonblocking();
        co_return read(catalog);
    } catch (const Error& error) {
        if (error.code() != ErrorCode::Unavailable) throw;
    }
    auto work = [&catalog = services.catalog, read = std::move(read)]() mutable {
        return read(catalog);
    };
    co_return co_await in_pool(services.pool, std::move(work));
}

}  // namespace divemesh::api
