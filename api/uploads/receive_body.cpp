#include "api/uploads/receive_body.hpp"

#include <boost/asio/experimental/awaitable_operators.hpp>
#include <chrono>
#include <vector>

#include "api/in_pool.hpp"
#include "api/token_watch.hpp"
#include "api/uploads/chunk_writer.hpp"
#include "api/uploads/upload_writer.hpp"
#include "schemas/error.hpp"

namespace divemesh::api {
namespace {

using Clock = std::chrono::steady_clock;

constexpr std::size_t kChunkBytes = std::size_t{128} << 10;  // two of them per request

enum class Ending { Whole, TooLong, TooSlow, Stopped, Invalid, Lost };

// Detects a client that keeps its connection open with a byte now and then.
class RateGuard {
public:
    explicit RateGuard(const ServiceLimits& limits)
        : window_(limits.rate_window),
          min_bytes_(limits.min_upload_bytes_per_s * window_.count() / 1000) {}

    bool too_slow(std::size_t num_bytes) {
        num_bytes_ += static_cast<std::int64_t>(num_bytes);
        const auto now = Clock::now();
        if (now - began_ < window_) return false;
        const bool slow = num_bytes_ < min_bytes_;
        began_ = now;
        num_bytes_ = 0;
        return slow;
    }

private:
    std::chrono::milliseconds window_;
    std::int64_t min_bytes_;
    std::int64_t num_bytes_ = 0;
    Clock::time_point began_ = Clock::now();
};

// Where a body comes from: its bytes, and the token that has to stay valid until the last one.
struct Sender {
    std::shared_ptr<BodyStream> stream;
    std::shared_ptr<TokenWatch> token;
};

// Writes one chunk. A failed write ends the read in parallel, which could take a minute.
Awaitable<void> write_received_chunk(Sender sender,
                                     Services services,
                                     std::shared_ptr<ByteSink> sink,
                                     std::span<const char> bytes) {
    auto write = [sender, &catalog = services.catalog, sink, bytes] {
        try {
            if (!sender.token->is_valid(catalog))
                throw Error(ErrorCode::Unauthorized,
                            "this token was revoked or has expired during the upload: continue "
                            "with a valid one, from the offset that HEAD gives");
            sink->write(bytes);
        } catch (...) {
            sender.stream->stop();
            throw;
        }
    };
    co_await in_pool(services.pool, std::move(write));
}

std::optional<Ending> ending_of(BodyRead::State state) {
    switch (state) {
        case BodyRead::State::More: return std::nullopt;
        case BodyRead::State::End: return Ending::Whole;
        case BodyRead::State::Stopped: return Ending::Stopped;
        case BodyRead::State::Invalid: return Ending::Invalid;
        case BodyRead::State::Lost: break;
    }
    return Ending::Lost;
}

// Writes one chunk while the next one is read.
Awaitable<Ending> stream_into(std::shared_ptr<ByteSink> sink, Sender sender, Services services) {
    using boost::asio::experimental::awaitable_operators::operator&&;
    std::vector<char> reading(kChunkBytes);
    std::vector<char> writing(kChunkBytes);
    RateGuard rate(services.limits);
    BodyRead read = co_await sender.stream->read(reading);
    for (;;) {
        const auto room = static_cast<std::size_t>(sink->room_bytes());
        std::optional<Ending> ending = ending_of(read.state);
        if (!ending && rate.too_slow(read.num_bytes)) ending = Ending::TooSlow;
        if (read.num_bytes > room) ending = Ending::TooLong;
        std::swap(reading, writing);
        const std::span<const char> bytes(writing.data(), std::min(read.num_bytes, room));
        if (ending) {
            co_await write_received_chunk(sender, services, sink, bytes);
            co_return *ending;
        }
        read = co_await (write_received_chunk(sender, services, sink, bytes) &&
                         sender.stream->read(reading));
    }
}

void throw_unless_whole(Ending ending) {
    switch (ending) {
        case Ending::Whole: return;
        case Ending::TooLong:
            throw Error(ErrorCode::TooLarge,
                        "the body exceeds Upload-Length: the excess is not kept");
        case Ending::TooSlow:
            throw Error(ErrorCode::Unavailable,
                        "the body arrives too slowly: ask with HEAD how much was received and send "
                        "the rest");
        case Ending::Stopped:
            throw Error(ErrorCode::Conflict,
                        "a newer request took over this upload, or the server is stopping");
        case Ending::Invalid:
            throw Error(ErrorCode::InvalidArgument,
                        "the chunks of the body are invalid: ask with HEAD how much was received "
                        "and send the rest");
        case Ending::Lost:
            throw Error(ErrorCode::Unavailable,
                        "the body did not arrive completely: ask with HEAD how much was received "
                        "and send the rest");
    }
}

Awaitable<Upload> receive_plain(Sender sender, Services services, Upload upload) {
    auto open = [services, upload] { return std::make_shared<UploadWriter>(services, upload); };
    auto writer = co_await in_pool(services.pool, std::move(open));
    std::exception_ptr failure;
    Ending ending = Ending::Lost;
    try {
        ending = co_await stream_into(writer, sender, services);
    } catch (...) {
        failure = std::current_exception();
    }
    auto finish = [writer] { return writer->finish(); };
    const Upload received = co_await in_pool(services.pool, std::move(finish));
    if (failure) std::rethrow_exception(failure);
    // A newer request has stopped this one, which has stored bytes all the same: it is told how
    // many.
    if (ending == Ending::Stopped && received.offset_bytes > upload.offset_bytes)
        co_return received;
    // If all bytes are here, a link that broke after the last one does not matter.
    if (!received.complete() || ending == Ending::TooLong) throw_unless_whole(ending);
    co_return received;
}

Awaitable<std::optional<Upload>> receive_checked(Sender sender,
                                                 Services services,
                                                 Upload upload,
                                                 std::shared_ptr<UploadChecksum> checksum) {
    auto open = [services, upload, checksum] {
        return std::make_shared<ChunkWriter>(services, upload, std::move(*checksum));
    };
    auto chunk = co_await in_pool(services.pool, std::move(open));
    throw_unless_whole(co_await stream_into(chunk, sender, services));
    auto begin = [services, upload, chunk]() -> std::shared_ptr<UploadWriter> {
        return chunk->is_right() ? std::make_shared<UploadWriter>(services, upload) : nullptr;
    };
    const auto writer = co_await in_pool(services.pool, std::move(begin));
    if (!writer) co_return std::nullopt;
    for (bool more = true; more;) {
        auto append = [chunk, writer] { return chunk->append_some(*writer); };
        more = co_await in_pool(services.pool, std::move(append));
    }
    auto finish = [writer] { return writer->finish(); };
    co_return co_await in_pool(services.pool, std::move(finish));
}

}  // namespace

Awaitable<std::optional<Upload>> receive_body(Request request,
                                              Services services,
                                              Upload upload,
                                              std::optional<UploadChecksum> checksum) {
    const Sender sender{request.stream, std::make_shared<TokenWatch>(request.token.id)};
    if (!checksum) co_return co_await receive_plain(sender, services, std::move(upload));
    auto shared = std::make_shared<UploadChecksum>(std::move(*checksum));
    co_return co_await receive_checked(sender, services, std::move(upload), std::move(shared));
}

}  // namespace divemesh::api
