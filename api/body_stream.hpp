#pragma once

#include <boost/asio/awaitable.hpp>
#include <chrono>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

namespace divemesh::api {

// How a read of a request's body ended: with bytes and more to come, at the end of the body,
// because the client disconnected or fell silent, because the body is invalid HTTP, or because
// stop() was called. Each of them may come with bytes.
struct BodyRead {
    enum class State { More, End, Lost, Invalid, Stopped };
    std::size_t num_bytes = 0;
    State state = State::More;
};

// The largest body of a request; those of uploads and streams may be larger.
constexpr std::size_t kMaxBodyBytes = std::size_t{1} << 20;

// A request's body as it arrives; the server supplies it. Only the connection's coroutine uses it,
// but any thread may call stop().
class BodyStream {
public:
    virtual ~BodyStream() = default;
    virtual std::optional<std::int64_t> length_bytes() const = 0;  // nullopt: chunked
    virtual boost::asio::awaitable<BodyRead> read(std::span<char> buffer) = 0;
    // Returns whether such a field came after the body; false before the end of the body.
    virtual bool has_trailer(std::string_view name) const = 0;
    virtual void must_end_within(std::chrono::seconds time) = 0;  // otherwise every read is Lost
    virtual void stop() = 0;
    virtual void note_valid_token() = 0;  // the connection is one of a known client
};

}  // namespace divemesh::api
