#pragma once

#include <boost/asio/any_io_executor.hpp>
#include <boost/asio/awaitable.hpp>
#include <chrono>
#include <functional>
#include <memory>
#include <optional>
#include <string>

namespace divemesh::api {

// Locks uploads: one request at a time works on an upload. A newer request asks the older one to
// stop and waits until its bytes are durable, so a client whose link broke need not wait for the
// old connection to time out. Thread-safe.
class UploadLocks {
    struct Holder;
    struct State;

public:
    // Holds the upload until it is destroyed. It may outlive the UploadLocks: a coroutine that
    // still waits when the server ends is destroyed with its io_context.
    class Lock {
    public:
        explicit Lock(std::shared_ptr<Holder> holder) : holder_(std::move(holder)) {}
        ~Lock();  // NOLINT(bugprone-exception-escape): throws only without an executor
        Lock(Lock&&) noexcept = default;
        Lock& operator=(Lock&&) = delete;

    private:
        std::shared_ptr<Holder> holder_;
    };

    explicit UploadLocks(const boost::asio::any_io_executor& executor,
                         std::chrono::milliseconds timeout = std::chrono::seconds(10));

    // Waits for the lock. `stop` is called, on any thread, when a newer request wants the upload;
    // it must not block. Throws Error{Locked} if the older request has not ended in time.
    boost::asio::awaitable<Lock> take(std::string upload_id, std::function<void()> stop);
    // Returns nullopt while a request holds the lock or waits for it.
    boost::asio::awaitable<std::optional<Lock>> take_if_free(std::string upload_id);

private:
    boost::asio::awaitable<std::shared_ptr<Holder>> hold_if_free(std::string upload_id);
    boost::asio::awaitable<std::shared_ptr<Holder>> wait(std::string upload_id,
                                                         std::function<void()> stop);

    std::shared_ptr<State> state_;
    std::chrono::milliseconds timeout_;
};

}  // namespace divemesh::api
