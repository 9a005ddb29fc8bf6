#include "storage/http_exchange.hpp"

#include <algorithm>
#include <array>
#include <cstdlib>
#include <curl/curl.h>
#include <exception>
#include <new>
#include <stdexcept>
#include <string_view>

namespace divemesh::storage {
namespace {

constexpr std::size_t kMaxHeaders = 100;
constexpr std::size_t kMaxIdle = 16;
constexpr long kBufferBytes = 512L << 10;
constexpr std::size_t kReservedBytes = std::size_t{1} << 20;

void start_curl() {
    static const CURLcode kStarted = curl_global_init(CURL_GLOBAL_DEFAULT);
    if (kStarted != CURLE_OK) throw std::runtime_error("libcurl does not start");
}

template <typename Value>
void set(CURL* handle, CURLoption option, Value value) {
    if (curl_easy_setopt(handle, option, value) != CURLE_OK)
        throw std::runtime_error("libcurl does not know option " + std::to_string(option));
}

std::string lower(std::string_view text) {
    std::string result(text);
    std::transform(result.begin(), result.end(), result.begin(), [](char c) {
        return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
    });
    return result;
}

std::string_view trimmed(std::string_view text) {
    const auto begin = text.find_first_not_of(" \t\r\n");
    if (begin == std::string_view::npos) return {};
    return text.substr(begin, text.find_last_not_of(" \t\r\n") - begin + 1);
}

// Returns whether the failure lies in the link or in a server that is starting, not in what was
// configured.
bool may_pass(CURLcode code) {
    constexpr std::array kLasting = {CURLE_UNSUPPORTED_PROTOCOL,
                                     CURLE_URL_MALFORMAT,
                                     CURLE_PEER_FAILED_VERIFICATION,
                                     CURLE_SSL_CACERT_BADFILE,
                                     CURLE_SSL_CERTPROBLEM,
                                     CURLE_SSL_ISSUER_ERROR,
                                     CURLE_OUT_OF_MEMORY};
    return std::find(kLasting.begin(), kLasting.end(), code) == kLasting.end();
}

int is_to_end(void* is_stopped, curl_off_t, curl_off_t, curl_off_t, curl_off_t) {
    return static_cast<std::atomic<bool>*>(is_stopped)->load() ? 1 : 0;
}

// One request and its answer, while libcurl calls back. No exception passes through it, which is C.
class Exchange {
public:
    Exchange(CURL* handle, const HttpRequest& request) : handle_(handle), request_(request) {
        set(handle, CURLOPT_WRITEFUNCTION, &on_body);
        set(handle, CURLOPT_WRITEDATA, this);
        set(handle, CURLOPT_HEADERFUNCTION, &on_header);
        set(handle, CURLOPT_HEADERDATA, this);
        set(handle, CURLOPT_ERRORBUFFER, message_.data());
        if (request.method == "HEAD") {
            set(handle, CURLOPT_NOBODY, 1L);
        } else if (request.body.read || request.method == "PUT") {
            set(handle, CURLOPT_UPLOAD, 1L);
            set(handle, CURLOPT_INFILESIZE_LARGE, curl_off_t{request.body.size_bytes});
            set(handle, CURLOPT_READFUNCTION, &on_read);
            set(handle, CURLOPT_READDATA, this);
            set(handle, CURLOPT_SEEKFUNCTION, &on_seek);
            set(handle, CURLOPT_SEEKDATA, this);
        } else if (request.method == "POST") {
            set(handle, CURLOPT_POSTFIELDSIZE, 0L);
            set(handle, CURLOPT_POSTFIELDS, "");
        }
        set(handle, CURLOPT_CUSTOMREQUEST, request.method.c_str());
        set(handle, CURLOPT_URL, request.url.c_str());
        for (const auto& [name, value] : request.headers) add(name + ": " + value);
        for (const char* own : {"Expect:", "Content-Type:", "Accept:"}) add(own);  // are not sent
        set(handle, CURLOPT_HTTPHEADER, headers_.get());
    }

    HttpAnswer run() {
        const CURLcode code = curl_easy_perform(handle_);
        if (thrown_) std::rethrow_exception(thrown_);
        curl_easy_getinfo(handle_, CURLINFO_RESPONSE_CODE, &answer_.status);
        if (code == CURLE_OK || answer_.is_cut_off) return std::move(answer_);
        if (code == CURLE_ABORTED_BY_CALLBACK) return {.failure = "this process is stopping"};
        HttpAnswer failed;
        failed.failure = message_.front() != '\0' ? message_.data() : curl_easy_strerror(code);
        failed.failure_may_pass = may_pass(code);
        return failed;
    }

private:
    void add(const std::string& line) {
        curl_slist* list = curl_slist_append(headers_.get(), line.c_str());
        if (list == nullptr) throw std::bad_alloc();
        static_cast<void>(headers_.release());
        headers_.reset(list);
    }

    template <typename Work>
    std::size_t guarded(std::size_t failed, const Work& work) {
        try {
            return work();
        } catch (...) {
            thrown_ = std::current_exception();
            return failed;
        }
    }
    static std::size_t on_body(char* bytes, std::size_t, std::size_t size, void* self) {
        auto& exchange = *static_cast<Exchange*>(self);
        return exchange.guarded(0, [&] { return exchange.take_body({bytes, size}); });
    }
    static std::size_t on_header(char* bytes, std::size_t, std::size_t size, void* self) {
        auto& exchange = *static_cast<Exchange*>(self);
        return exchange.guarded(0, [&] { return exchange.take_header({bytes, size}); });
    }
    static std::size_t on_read(char* bytes, std::size_t, std::size_t size, void* self) {
        auto& exchange = *static_cast<Exchange*>(self);
        return exchange.guarded(CURL_READFUNC_ABORT, [&] { return exchange.give({bytes, size}); });
    }
    static int on_seek(void* self, curl_off_t offset, int origin) {
        if (origin != SEEK_SET) return CURL_SEEKFUNC_CANTSEEK;
        static_cast<Exchange*>(self)->num_sent_ = offset;
        return CURL_SEEKFUNC_OK;
    }

    std::size_t take_body(std::string_view bytes) {
        const std::size_t size =
            std::min(bytes.size(), request_.max_answer_bytes - answer_.body.size());
        if (answer_.body.empty())
            answer_.body.reserve(std::min(request_.max_answer_bytes, kReservedBytes));
        answer_.body.append(bytes.substr(0, size));
        answer_.is_cut_off = size < bytes.size();
        return size;
    }
    std::size_t take_header(std::string_view line) {
        const auto colon = line.find(':');
        if (line.starts_with("HTTP/")) {  // an answer 100 came before
            answer_.headers.clear();
        } else if (colon != std::string_view::npos && answer_.headers.size() < kMaxHeaders) {
            answer_.headers[lower(line.substr(0, colon))] = trimmed(line.substr(colon + 1));
        }
        return line.size();
    }
    std::size_t give(std::span<char> buffer) {
        if (!request_.body.read) return 0;
        const auto left = static_cast<std::size_t>(request_.body.size_bytes - num_sent_);
        const auto size =
            request_.body.read(num_sent_, buffer.first(std::min(buffer.size(), left)));
        num_sent_ += static_cast<std::int64_t>(size);
        return size;
    }

    CURL* handle_;
    const HttpRequest& request_;
    HttpAnswer answer_;
    std::int64_t num_sent_ = 0;
    std::exception_ptr thrown_;
    std::array<char, CURL_ERROR_SIZE> message_{};
    std::unique_ptr<curl_slist, void (*)(curl_slist*)> headers_{nullptr, curl_slist_free_all};
};

}  // namespace

HttpExchange::HttpExchange(const HttpTimeouts& timeouts) : timeouts_(timeouts) {
    start_curl();
    // Like the programs of Amazon and others.
    if (const char* file = std::getenv("AWS_CA_BUNDLE")) certificates_ = file;
}

HttpExchange::~HttpExchange() = default;

HttpAnswer HttpExchange::send(const HttpRequest& request) {
    Handle handle = take();
    CURL* curl = handle.get();
    set(curl, CURLOPT_NOSIGNAL, 1L);
    set(curl, CURLOPT_PROTOCOLS_STR, "http,https");
    set(curl, CURLOPT_HTTP_VERSION, long{CURL_HTTP_VERSION_1_1});
    set(curl, CURLOPT_FOLLOWLOCATION, 0L);
    set(curl, CURLOPT_CONNECTTIMEOUT_MS, static_cast<long>(timeouts_.connect.count()));
    set(curl, CURLOPT_LOW_SPEED_LIMIT, 1L);
    set(curl, CURLOPT_LOW_SPEED_TIME, static_cast<long>(timeouts_.silence.count()));
    set(curl, CURLOPT_BUFFERSIZE, kBufferBytes);
    set(curl, CURLOPT_UPLOAD_BUFFERSIZE, kBufferBytes);
    if (!certificates_.empty()) set(curl, CURLOPT_CAINFO, certificates_.c_str());
    set(curl, CURLOPT_NOPROGRESS, 0L);  // it asks every second at least whether to go on
    set(curl, CURLOPT_XFERINFOFUNCTION, &is_to_end);
    set(curl, CURLOPT_XFERINFODATA, &is_stopped_);
    HttpAnswer answer = Exchange(curl, request).run();
    curl_easy_reset(curl);  // keeps its connection
    give_back(std::move(handle));
    return answer;
}

HttpExchange::Handle HttpExchange::take() {
    {
        const std::lock_guard lock(mutex_);
        if (!idle_.empty()) {
            Handle handle = std::move(idle_.back());
            idle_.pop_back();
            return handle;
        }
    }
    Handle handle(curl_easy_init(), curl_easy_cleanup);
    if (!handle) throw std::bad_alloc();
    return handle;
}

void HttpExchange::give_back(Handle handle) {
    const std::lock_guard lock(mutex_);
    if (idle_.size() < kMaxIdle) idle_.push_back(std::move(handle));
}

}  // namespace divemesh::storage
