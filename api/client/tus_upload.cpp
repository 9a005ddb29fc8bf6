#include "api/client/tus_upload.hpp"

#include <algorithm>
#include <charconv>
#include <optional>
#include <thread>

#include "schemas/error.hpp"

namespace divemesh::api::client {
namespace {

const std::string kUploadsPath = "/api/v1/uploads";

std::string base64(std::string_view bytes) {
    constexpr char letters[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    std::string text;
    for (std::size_t i = 0; i < bytes.size(); i += 3) {
        const std::size_t count = std::min<std::size_t>(3, bytes.size() - i);
        unsigned group = 0;
        for (std::size_t j = 0; j < 3; ++j)
            group = group << 8 | (j < count ? static_cast<unsigned char>(bytes[i + j]) : 0U);
        for (std::size_t j = 0; j < 4; ++j)
            text += j <= count ? letters[group >> (18 - 6 * j) & 63] : '=';
    }
    return text;
}

class TusUpload {
public:
    TusUpload(const Account& account,
              ByteSource& source,
              const UploadState& state,
              const TusObserver& observer,
              const TusSettings& settings)
        : account_(account),
          source_(source),
          state_(state),
          observer_(observer),
          settings_(settings),
          connection_(account.server, settings.stall),
          backoff_(settings.give_up_after, observer.on_wait) {}

    std::string run(const std::map<std::string, std::string>& metadata) {
        path_ = state_.upload_path();
        while (true) {
            try {
                if (!path_) create(metadata);
                if (!offset_) ask_offset();
                if (!offset_) continue;  // the server has forgotten it: create it anew
                if (*offset_ == source_.size_bytes()) return *path_;
                send_chunk();
            } catch (const Error& error) {
                if (error.code() != ErrorCode::Unavailable) throw;
                offset_.reset();
                backoff_.wait(error);
            }
        }
    }

private:
    HttpRequest request(const std::string& method, const std::string& target) const {
        HttpRequest result{method, target, authorization(account_), ""};
        result.headers.emplace_back("Tus-Resumable", "1.0.0");
        return result;
    }

    void create(const std::map<std::string, std::string>& metadata) {
        HttpRequest post = request("POST", kUploadsPath);
        post.headers.emplace_back("Upload-Length", std::to_string(source_.size_bytes()));
        post.headers.emplace_back("Upload-Metadata", tus_metadata(metadata));
        const HttpResponse response = connection_.send(post);
        if (response.status != 201) refuse(response);
        path_ = path_of_location(response.header("location"));
        state_.remember(*path_);
        offset_ = 0;
    }

    // Location may be relative, or absolute by any name the server has behind a proxy.
    std::string path_of_location(const std::string& location) const {
        const std::size_t start = location.find(kUploadsPath + "/");
        if (start == std::string::npos)
            throw Error(ErrorCode::Unsupported,
                        "the server put the upload at \"" + location + "\": not a divemesh server");
        return location.substr(start);
    }

    void ask_offset() {
        const HttpResponse response = connection_.send(request("HEAD", *path_));
        const bool known = response.status != 404 && response.status != 410;
        if (known && response.status != 200 && response.status != 204) refuse(response);
        if (!known || response.header("upload-length") != std::to_string(source_.size_bytes())) {
            state_.forget();
            path_.reset();
            return;
        }
        moved_to(offset_in(response));
        if (*offset_ > 0 && observer_.on_resumed) observer_.on_resumed(*offset_);
    }

    void send_chunk() {
        const std::int64_t start = *offset_;
        HttpRequest patch = request("PATCH", *path_);
        patch.headers.emplace_back("Content-Type", "application/offset+octet-stream");
        patch.headers.emplace_back("Upload-Offset", std::to_string(start));
        BodyRange body;
        body.source = &source_;
        body.offset = start;
        body.length = std::min(settings_.chunk_bytes, source_.size_bytes() - start);
        const auto began = std::chrono::steady_clock::now();
        if (start + body.length == source_.size_bytes())
            patch.patience = hashing_patience(source_.size_bytes());
        body.on_sent = [&](std::int64_t sent) {
            if (observer_.on_progress) observer_.on_progress(start + sent);
            if (settings_.max_bytes_per_s > 0.0)
                std::this_thread::sleep_until(
                    began + std::chrono::microseconds(static_cast<std::int64_t>(
                                static_cast<double>(sent) / settings_.max_bytes_per_s * 1e6)));
        };
        const HttpResponse response = connection_.send(patch, body);
        if (response.status != 204) refuse(response);
        moved_to(offset_in(response));
        if (*offset_ <= start)
            throw Error(ErrorCode::Unavailable, "the server took no byte of the upload");
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
                        "the server answered Upload-Offset \"" + text + "\"");
        return offset;
    }

    // 409: another offset than we thought; 423: an older request still holds the upload.
    [[noreturn]] static void refuse(const HttpResponse& response) {
        if (response.status == 409 || response.status == 423)
            throw Error(ErrorCode::Unavailable, error_of(response).what());
        throw error_of(response);
    }

    const Account& account_;
    ByteSource& source_;
    const UploadState& state_;
    const TusObserver& observer_;
    const TusSettings& settings_;
    HttpConnection connection_;
    Backoff backoff_;
    std::optional<std::string> path_;
    std::int64_t highest_offset_ = 0;
    std::optional<std::int64_t> offset_;  // nothing: the server has to be asked
};

}  // namespace

std::string tus_metadata(const std::map<std::string, std::string>& metadata) {
    std::string text;
    for (const auto& [key, value] : metadata)
        text += (text.empty() ? "" : ",") + key + " " + base64(value);
    return text;
}

std::string upload_by_tus(const Account& account,
                          ByteSource& source,
                          const std::map<std::string, std::string>& metadata,
                          const UploadState& state,
                          const TusObserver& observer,
                          const TusSettings& settings) {
    return TusUpload(account, source, state, observer, settings).run(metadata);
}

}  // namespace divemesh::api::client
