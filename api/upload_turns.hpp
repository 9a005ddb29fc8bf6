#pragma once

#include <boost/asio/any_io_executor.hpp>
#include <boost/asio/awaitable.hpp>
#include <chrono>
#include <functional>
#include <memory>
#include <optional>
#include <string>

namespace divemesh::api {

// One request at a time works on an upload. A newer one asks the older to stop and waits until it
// has made its bytes durable: a client whose link broke need not wait for the old connection to
// time out. Thread-safe.
class UploadTurns {
    struct Holder;
    struct State;

public:
    // Until it is destroyed the upload is the holder's alone. It may outlive the UploadTurns: what
    // still waits when the server ends is destroyed with its io_context.
    class Turn {
    public:
        explicit Turn(std::shared_ptr<Holder> holder) : holder_(std::move(holder)) {}
        ~Turn();
        Turn(Turn&&) noexcept = default;
        Turn& operator=(Turn&&) = delete;

    private:
        std::shared_ptr<Holder> holder_;
    };

    explicit UploadTurns(const boost::asio::any_io_executor& executor,
                         std::chrono::milliseconds patience = std::chrono::seconds(10));

    // `stop` is called, on any thread, when a newer request wants the upload; it must not block.
    // Throws Error{Locked} when the older request has not ended in time.
    boost::asio::awaitable<Turn> take(std::string upload_id, std::function<void()> stop);
    // Nothing while a request has it or waits for it.
    boost::asio::awaitable<std::optional<Turn>> take_if_free(std::string upload_id);

private:
    boost::asio::awaitable<std::shared_ptr<Holder>> hold_if_free(std::string upload_id);
    boost::asio::awaitable<std::shared_ptr<Holder>> wait(std::string upload_id,
                                                         std::function<void()> stop);

    std::shared_ptr<State> state_;
    std::chrono::milliseconds patience_;
};

}  // namespace divemesh::api
