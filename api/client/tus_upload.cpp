#include "api/client/tus_upload.hpp"

#include <algorithm>
#include <mutex>
#include <thread>

#include "api/client/tus_transfer.hpp"
#include "schemas/error.hpp"

namespace divemesh::api::client {
namespace {

std::string base64(std::string_view bytes) {
    constexpr char kLetters[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    std::string text;
    for (std::size_t i = 0; i < bytes.size(); i += 3) {
        const std::size_t count = std::min<std::size_t>(3, bytes.size() - i);
        unsigned group = 0;
        for (std::size_t j = 0; j < 3; ++j)
            group = group << 8 | (j < count ? static_cast<unsigned char>(bytes[i + j]) : 0U);
        for (std::size_t j = 0; j < 4; ++j)
            text += j <= count ? kLetters[group >> (18 - 6 * j) & 63] : '=';
    }
    return text;
}

// A range of a source that other threads read as well.
class Slice : public ByteSource {
public:
    Slice(ByteSource& whole, std::mutex& mutex, std::int64_t start, std::int64_t end)
        : whole_(whole), mutex_(mutex), start_(start), end_(end) {}

    std::int64_t size_bytes() const override { return end_ - start_; }
    std::size_t read_at(std::int64_t offset, std::span<char> buffer) override {
        const auto left =
            static_cast<std::size_t>(std::max<std::int64_t>(size_bytes() - offset, 0));
        const std::lock_guard lock(mutex_);
        return whole_.read_at(start_ + offset, buffer.first(std::min(buffer.size(), left)));
    }

private:
    ByteSource& whole_;
    std::mutex& mutex_;
    std::int64_t start_;
    std::int64_t end_;
};

class Upload {
public:
    Upload(const Account& account,
           ByteSource& source,
           const std::map<std::string, std::string>& metadata,
           const UploadState& state,
           const TusObserver& observer,
           const TusSettings& settings)
        : source_(source),
          state_(state),
          observer_(observer),
          rate_(settings.max_bytes_per_s),
          context_{account, settings, rate_, stop_.get_token()},
          creation_{{"Upload-Metadata", tus_metadata(metadata)}},
          remembered_(state.load()) {}

    std::string run() {
        if (remembered_.upload.empty() && remembered_.parts.empty() && wanted_parts() > 1)
            remembered_.parts.resize(wanted_parts());
        if (remembered_.parts.empty()) return send_whole();
        try {
            return send_parts();
        } catch (const Error& error) {
            if (error.code() != ErrorCode::NotFound) throw;
        }
        remembered_ = {};  // the server no longer has a part that was complete
        state_.forget();
        remembered_.parts.resize(wanted_parts());
        return send_parts();
    }

private:
    std::size_t wanted_parts() const {
        const std::int64_t max_num_parts = std::max<std::int64_t>(source_.size_bytes(), 1);
        return static_cast<std::size_t>(
            std::clamp<std::int64_t>(context_.settings.num_parts, 1, max_num_parts));
    }

    std::string send_whole() {
        const auto set_path = [this](const std::string& path) { remembered_.upload = path; };
        return send_by_tus(
            context_, source_, creation_, remembered_.upload, observer_of(0, set_path));
    }

    std::string send_parts() {
        if (!remembered_.joining) {
            send_all_parts();
            remembered_.joining = true;
            state_.save(remembered_);
        }
        const auto on_wait = observer_of(0, {}).on_wait;
        return join_by_tus(context_, remembered_.parts, source_.size_bytes(), creation_, on_wait);
    }

    void send_all_parts() {
        bytes_done_.assign(remembered_.parts.size(), 0);
        std::vector<std::jthread> threads;
        for (std::size_t i = 0; i < remembered_.parts.size(); ++i)
            threads.emplace_back([this, i] { send_part(i); });
        threads.clear();  // joins
        if (failure_) std::rethrow_exception(failure_);
    }

    // Sends one part. The first part that fails for good stops the others.
    void send_part(std::size_t number) {
        try {
            const auto count = static_cast<std::int64_t>(remembered_.parts.size());
            const auto bound = [&](std::size_t i) {
                const std::int64_t each = source_.size_bytes() / count;
                const std::int64_t rest = source_.size_bytes() % count;
                const auto index = static_cast<std::int64_t>(i);
                return each * index + std::min(rest, index);
            };
            Slice slice(source_, reading_, bound(number), bound(number + 1));
            const auto set_path = [this, number](const std::string& path) {
                remembered_.parts[number] = path;
            };
            send_by_tus(context_,
                        slice,
                        {{"Upload-Concat", "partial"}},
                        remembered_.parts[number],
                        observer_of(number, set_path));
        } catch (...) {
            const std::lock_guard lock(telling_);
            if (!failure_) failure_ = std::current_exception();
            stop_.request_stop();
        }
    }

    TransferObserver observer_of(std::size_t part,
                                 const std::function<void(const std::string&)>& set_path) {
        TransferObserver result;
        result.on_path = [this, set_path](const std::string& path) {
            const std::lock_guard lock(telling_);
            set_path(path);
            state_.save(remembered_);
        };
        result.on_progress = [this, part](std::int64_t bytes_done) {
            const std::lock_guard lock(telling_);
            bytes_done_[part] = bytes_done;
            std::int64_t sum = 0;
            for (const std::int64_t done : bytes_done_) sum += done;
            if (observer_.on_progress) observer_.on_progress(sum);
        };
        result.on_resumed = [this, part](std::int64_t offset) {
            const std::lock_guard lock(telling_);
            bytes_done_[part] = offset;
            if (observer_.on_resumed) observer_.on_resumed(offset);
        };
        result.on_wait = [this](const Error& reason, std::chrono::milliseconds pause) {
            const std::lock_guard lock(telling_);
            if (observer_.on_wait) observer_.on_wait(reason, pause);
        };
        return result;
    }

    ByteSource& source_;
    const UploadState& state_;
    const TusObserver& observer_;
    RateLimiter rate_;
    std::stop_source stop_;
    TusContext context_;
    TusHeaders creation_;
    std::mutex reading_;
    std::mutex telling_;  // guards everything below
    RememberedUpload remembered_;
    std::vector<std::int64_t> bytes_done_ = {0};  // of each part
    std::exception_ptr failure_;
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
    return Upload(account, source, metadata, state, observer, settings).run();
}

}  // namespace divemesh::api::client
