#pragma once

#include <boost/asio/awaitable.hpp>
#include <chrono>
#include <cstdint>
#include <optional>
#include <span>

namespace divemesh::api {

// How a read of a request's body ended: with bytes and more to come, at its end, because the
// client went or fell silent, or because stop() was called. Bytes may come with each of them.
struct BodyRead {
    enum class State { More, End, Lost, Stopped };
    std::size_t num_bytes = 0;
    State state = State::More;
};

// A request's body as it arrives; the server supplies it. Used by the connection's coroutine alone,
// but stop() is for any thread.
class BodyStream {
public:
    virtual ~BodyStream() = default;
    virtual std::optional<std::int64_t> length_bytes() const = 0;  // nothing: chunked, not known
    virtual boost::asio::awaitable<BodyRead> read(std::span<char> buffer) = 0;
    virtual void must_end_within(std::chrono::seconds time) = 0;  // else every read is Lost
    virtual void stop() = 0;
};

}  // namespace divemesh::api
