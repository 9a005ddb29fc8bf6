#pragma once

#include <boost/asio/awaitable.hpp>
#include <boost/asio/co_spawn.hpp>
#include <boost/asio/thread_pool.hpp>
#include <boost/asio/use_awaitable.hpp>
#include <type_traits>
#include <utility>

namespace divemesh::api {

template <typename Work>
boost::asio::awaitable<std::invoke_result_t<Work>> run_work(Work work) {
    co_return work();
}

// Runs `work`, which may block (SQL, disk, hashing), in the pool. The caller resumes on its own
// executor with the result or the exception. `work` is moved in: what it refers to must outlive the
// co_await.
template <typename Work>
boost::asio::awaitable<std::invoke_result_t<Work>> in_pool(boost::asio::thread_pool& pool,
                                                           Work work) {
    return boost::asio::co_spawn(
        pool.get_executor(), run_work(std::move(work)), boost::asio::use_awaitable);
}

}  // namespace divemesh::api
