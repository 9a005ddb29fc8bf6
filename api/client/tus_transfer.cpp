#include "api/client/tus_transfer.hpp"

#include <algorithm>
#include <charconv>
#include <limits>

#include "schemas/error.hpp"

namespace divemesh::api::client {
namespace {

const std::string kUploadsPath = "/api/v1/uploads";
constexpr std::int64_t kMinPieceBytes = std::int64_t{16} << 10;

// Throws the error of a refused request. 409 means another offset than expected, 423 that an older
// request still holds the upload, 507 that the disk is full: these are worth a retry, because an
// operator can free space.
[[noreturn]] void refuse(const HttpResponse& response) {
    if (response.status == 409 || response.status == 423 || response.status == 507)
        throw Error(ErrorCode::Unavailable, error_of(response).what());
    throw error_of(response);
}

HttpRequest tus_request(const Account& account,
                        const std::string& method,
                        const std::string& target,
                        const TusHeaders& headers = {}) {
    HttpRequest request{method, target, authorization(account), ""};
    request.headers.emplace_back("Tus-Resumable", "1.0.0");
    request.headers.insert(request.headers.end(), headers.begin(), headers.end());
    return request;
}

// Returns the path of a Location, which may be relative, or absolute with any name that a proxy
// gives the server.
std::string path_of_location(const HttpResponse& response) {
    const std::string location = response.header("location");
    const std::size_t start = location.find(kUploadsPath + "/");
    if (start == std::string::npos)
        throw Error(
            ErrorCode::Unsupported,
            "the server put the upload at \"" + location + "\": it is not a divemesh server");
    return location.substr(start);
}

class Transfer {
public:
    Transfer(const TusContext& context,
             ByteSource& source,
             const TusHeaders& creation,
             const TransferObserver& observer)
        : context_(context),
          source_(source),
          creation_(creation),
          observer_(observer),
          connection_(context.account.server, context.settings.stall),
          backoff_(context.settings.give_up_after, observer.on_wait, context.stop) {}

    std::string run(std::string path) {
        path_ = std::move(path);
        while (true) {
            try {
                if (path_.empty()) create();
                if (!offset_) ask_offset();
                if (!offset_) continue;  // the server no longer has it: create it again
                if (*offset_ == source_.size_bytes()) return path_;
                send_chunk();
            } catch (const Error& error) {
                if (error.code() != ErrorCode::Unavailable) throw;
                offset_.reset();
                backoff_.wait(error);
            }
        }
    }

private:
    void set_path(std::string path) {
        path_ = std::move(path);
        observer_.on_path(path_);
    }

    void create() {
        HttpRequest post = tus_request(context_.account, "POST", kUploadsPath, creation_);
        post.headers.emplace_back("Upload-Length", std::to_string(source_.size_bytes()));
        const HttpResponse response = connection_.send(post);
        if (response.status != 201) refuse(response);
        set_path(path_of_location(response));
        offset_ = 0;
    }

    void ask_offset() {
        const HttpResponse response =
            connection_.send(tus_request(context_.account, "HEAD", path_));
        const bool known = response.status != 404 && response.status != 410;
        if (known && response.status != 200 && response.status != 204) refuse(response);
        if (!known || response.header("upload-length") != std::to_string(source_.size_bytes())) {
            set_path("");
            return;
        }
        moved_to(offset_in(response));
        if (*offset_ > 0) observer_.on_resumed(*offset_);
    }

    void send_chunk() {
        const std::int64_t start = *offset_;
        const std::int64_t left = source_.size_bytes() - start;
        HttpRequest patch = tus_request(context_.account,
                                        "PATCH",
                                        path_,
                                        {{"Content-Type", "application/offset+octet-stream"},
                                         {"Upload-Offset", std::to_string(start)}});
        BodyRange body;
        body.source = &source_;
        body.offset = start;
        body.length = std::min({context_.settings.chunk_bytes, max_piece_bytes_, left});
        if (context_.settings.max_bytes_per_s > 0.0)  // several a second: silence is a broken link
            body.write_bytes =
                static_cast<std::size_t>(std::clamp(context_.settings.max_bytes_per_s / 8.0,
                                                    1024.0,
                                                    static_cast<double>(body.write_bytes)));
        if (start + body.length == source_.size_bytes())
            patch.timeout = hashing_timeout(source_.size_bytes());
        body.on_sent = [this, start, before = std::int64_t{0}](std::int64_t sent) mutable {
            if (context_.stop.stop_requested())
                throw Error(ErrorCode::Cancelled, "stopped while sending");
            observer_.on_progress(start + sent);
            context_.rate.sent(sent - before);
            before = sent;
        };
        const HttpResponse response = connection_.send(patch, body);
        if (response.status == 404 || response.status == 410) {  // it expired meanwhile
            set_path("");
            offset_.reset();
            return;
        }
        if (is_refused_by_proxy(response)) {
            send_smaller_than(body.length);
            return;
        }
        if (response.status != 204) refuse(response);
        moved_to(offset_in(response));
        if (*offset_ <= start)
            throw Error(ErrorCode::Unavailable, "the server accepted no byte of the upload");
    }

    // The server's own refusals are problem+json.
    static bool is_refused_by_proxy(const HttpResponse& response) {
        return response.status == 413 &&
               !response.header("content-type").starts_with("application/problem+json");
    }

    void send_smaller_than(std::int64_t refused_bytes) {
        const std::string advice =
            "allow bodies of any size there, with nginx by client_max_body_size 0";
        const std::string what = "a proxy in front of the server refuses requests of " +
                                 std::to_string(refused_bytes) + " bytes: ";
        if (refused_bytes <= kMinPieceBytes) throw Error(ErrorCode::TooLarge, what + advice);
        max_piece_bytes_ = std::max(refused_bytes / 4, kMinPieceBytes);
        offset_.reset();  // the proxy closes the connection
        if (observer_.on_wait)
            observer_.on_wait(Error(ErrorCode::TooLarge,
                                    what + "sending " + std::to_string(max_piece_bytes_) +
                                        " at a time, which is slower; " + advice),
                              std::chrono::milliseconds(0));
    }

    void moved_to(std::int64_t offset) {
        offset_ = offset;
        if (offset > highest_offset_) backoff_.moved();
        highest_offset_ = std::max(highest_offset_, offset);
    }

    std::int64_t offset_in(const HttpResponse& response) const {
        const std::string text = response.header("upload-offset");
        std::int64_t offset = -1;
        const auto [end, failure] = std::from_chars(text.data(), text.data() + text.size(), offset);
        if (failure != std::errc{} || end != text.data() + text.size() || offset < 0 ||
            offset > source_.size_bytes())
            throw Error(ErrorCode::Unsupported,
                        "the server answered the invalid Upload-Offset \"" + text + "\"");
        return offset;
    }

    const TusContext& context_;
    ByteSource& source_;
    const TusHeaders& creation_;
    const TransferObserver& observer_;
    HttpConnection connection_;
    Backoff backoff_;
    std::string path_;  // "": to be created
    std::int64_t highest_offset_ = 0;
    std::int64_t max_piece_bytes_ =
        std::numeric_limits<std::int64_t>::max();  // that a proxy lets by
    std::optional<std::int64_t> offset_;           // nullopt: the server has to be asked
};

}  // namespace

std::string send_by_tus(const TusContext& context,
                        ByteSource& source,
                        const TusHeaders& creation,
                        const std::string& path,
                        const TransferObserver& observer) {
    return Transfer(context, source, creation, observer).run(path);
}

// Safe to repeat: the server returns the same resource for the same parts.
std::string join_by_tus(const TusContext& context,
                        const std::vector<std::string>& parts,
                        std::int64_t size_bytes,
                        const TusHeaders& creation,
                        const Backoff::OnWait& on_wait) {
    HttpConnection connection(context.account.server, context.settings.stall);
    Backoff backoff(context.settings.give_up_after, on_wait, context.stop);
    HttpRequest post = tus_request(context.account, "POST", kUploadsPath, creation);
    std::string concat = "final;";
    for (const auto& part : parts) concat += (part == parts.front() ? "" : " ") + part;
    post.headers.emplace_back("Upload-Concat", concat);
    post.timeout = 2 * hashing_timeout(size_bytes);  // the server copies them as well
    return backoff.until_done([&] {
        const HttpResponse response = connection.send(post);
        if (response.status != 201) refuse(response);
        return path_of_location(response);
    });
}

}  // namespace divemesh::api::client
