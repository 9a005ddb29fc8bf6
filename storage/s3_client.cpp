#include "storage/s3_client.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <openssl/evp.h>
#include <random>
#include <thread>
#include <utility>

#include "schemas/content_hash.hpp"
#include "schemas/error.hpp"
#include "storage/xml_tree.hpp"

namespace divemesh::storage {
namespace {

using Clock = std::chrono::steady_clock;
using namespace std::chrono_literals;

constexpr std::size_t kHashBytes = std::size_t{256} << 10;
constexpr std::size_t kMaxNames = 1'000'000;
constexpr auto kFirstPause = 100ms;
constexpr auto kMaxPause = 5000ms;
constexpr int kMinTries = 3;

std::string sha256_of(const HttpBody& body) {
    Sha256 hash;
    std::vector<char> buffer(
        std::min(kHashBytes, static_cast<std::size_t>(std::max<std::int64_t>(body.size_bytes, 1))));
    for (std::int64_t offset = 0; offset < body.size_bytes;) {
        const auto left = static_cast<std::size_t>(body.size_bytes - offset);
        const auto size = body.read(offset, std::span(buffer).first(std::min(buffer.size(), left)));
        if (size == 0) throw Error(ErrorCode::Unavailable, "a file became shorter as it was read");
        hash.update(std::span(buffer).first(size));
        offset += static_cast<std::int64_t>(size);
    }
    return hash.hex();
}

std::string amazon_time(std::time_t time) {
    std::tm parts{};
    gmtime_r(&time, &parts);
    std::array<char, 32> text{};
    const auto size = std::strftime(text.data(), text.size(), "%Y%m%dT%H%M%SZ", &parts);
    return {text.data(), size};
}

// Pauses between tries. They grow to kMaxPause; half of each is by chance, so that those who failed
// together come back apart.
class Patience {
public:
    explicit Patience(std::chrono::milliseconds lasts) : end_(Clock::now() + lasts) {}

    // Pauses. Returns false at once if there is no patience left. One try alone may take longer
    // than it lasts, on a slow link, so that a few are always had.
    bool waits() {
        if (++num_tries_ >= kMinTries && Clock::now() > end_) return false;
        std::uniform_int_distribution<std::int64_t> chance(next_.count() / 2, next_.count());
        std::this_thread::sleep_for(std::chrono::milliseconds(chance(random_)));
        next_ = std::min<std::chrono::milliseconds>(2 * next_, kMaxPause);
        return true;
    }

private:
    Clock::time_point end_;
    int num_tries_ = 0;
    std::chrono::milliseconds next_ = kFirstPause;
    std::minstd_rand random_{std::random_device{}()};
};

std::string md5_of(std::string_view bytes) {
    std::array<unsigned char, EVP_MAX_MD_SIZE> digest{};
    unsigned size = 0;
    if (EVP_Digest(bytes.data(), bytes.size(), digest.data(), &size, EVP_md5(), nullptr) != 1)
        throw std::runtime_error("OpenSSL cannot compute MD5");
    return {digest.begin(), digest.begin() + size};
}

std::string base64(std::string_view bytes) {
    std::string text(4 * ((bytes.size() + 2) / 3) + 1, '\0');
    const int size = EVP_EncodeBlock(reinterpret_cast<unsigned char*>(text.data()),
                                     reinterpret_cast<const unsigned char*>(bytes.data()),
                                     static_cast<int>(bytes.size()));
    text.resize(static_cast<std::size_t>(size));
    return text;
}

// Returns the ETag of an object of these parts where the store takes MD5 for them, as nearly all
// do; otherwise "".
std::string etag_of_parts(const std::vector<std::string>& etags) {
    std::string digests;
    for (const std::string& etag : etags) {
        const bool is_md5 = etag.size() == 34 && etag.front() == '"' && etag.back() == '"';
        for (std::size_t i = 1; is_md5 && i < 33; i += 2) {
            unsigned char byte = 0;
            const auto [end, error] = std::from_chars(&etag[i], &etag[i] + 2, byte, 16);
            if (end != &etag[i] + 2) return "";
            digests += static_cast<char>(byte);
        }
        if (!is_md5) return "";
    }
    return '"' + to_hex(md5_of(digests)) + '-' + std::to_string(etags.size()) + '"';
}

std::string escaped(const std::string& text) {
    std::string result;
    for (const char c : text) switch (c) {
            case '&': result += "&amp;"; break;
            case '<': result += "&lt;"; break;
            case '>': result += "&gt;"; break;
            case '"': result += "&quot;"; break;
            default: result += c;
        }
    return result;
}

std::string completion_of(const std::vector<std::string>& etags) {
    std::string text = "<CompleteMultipartUpload>";
    for (std::size_t i = 0; i < etags.size(); ++i)
        text += "<Part><PartNumber>" + std::to_string(i + 1) + "</PartNumber><ETag>" +
                escaped(etags[i]) + "</ETag></Part>";
    return text + "</CompleteMultipartUpload>";
}

std::string header(const HttpAnswer& answer, const std::string& name) {
    const auto found = answer.headers.find(name);
    return found == answer.headers.end() ? "" : found->second;
}

std::string without_prefix(const std::string& text, const std::string& prefix) {
    if (!text.starts_with(prefix))
        throw Error(ErrorCode::Unavailable, "the object store lists what was not asked for");
    return text.substr(prefix.size());
}

}  // namespace

HttpBody body_of(std::string text) {
    const auto size = static_cast<std::int64_t>(text.size());
    return {.size_bytes = size,
            .read = [text = std::move(text)](std::int64_t offset, std::span<char> buffer) {
                return text.copy(buffer.data(), buffer.size(), static_cast<std::size_t>(offset));
            }};
}

S3Client::S3Client(S3Location location, S3Credentials credentials, S3Settings settings)
    : location_(std::move(location)),
      credentials_(std::move(credentials)),
      settings_(std::move(settings)),
      http_(settings_.timeouts) {}

HttpAnswer S3Client::try_once(const Request& request, const std::string& sha256) {
    const std::string time = amazon_time(settings_.clock());
    SignedParts parts{request.method, location_.path(request.key), request.query, request.headers};
    parts.headers["host"] = location_.host();
    parts.headers["x-amz-content-sha256"] = sha256;
    parts.headers["x-amz-date"] = time;
    if (!credentials_.session_token.empty())
        parts.headers["x-amz-security-token"] = credentials_.session_token;
    HttpRequest http{
        .method = request.method,
        .url = location_.scheme() + "://" + location_.host() + percent_encoded(parts.path, true),
        .headers = parts.headers,
        .body = request.body,
        .max_answer_bytes = request.max_answer_bytes};
    if (!request.query.empty()) http.url += '?' + canonical_query(request.query);
    http.headers["authorization"] =
        sigv4_authorization(parts, credentials_, location_.region, time, sha256);
    return http_.send(http);
}

// Tries until there is an answer that will not change, or patience ends.
HttpAnswer S3Client::send(const Request& request) {
    const std::string sha256 = sha256_of(request.body);
    Patience patience(settings_.patience);
    for (;;) {
        HttpAnswer answer = try_once(request, sha256);
        if (answer.status >= 200 && answer.status < 300) return answer;
        if (!may_pass(answer, refusal_of(answer)) || !patience.waits()) return answer;
    }
}

// Returns an answer of success; throws otherwise.
HttpAnswer S3Client::require(const std::string& doing, const Request& request) {
    HttpAnswer answer = send(request);
    if (answer.status >= 200 && answer.status < 300) return answer;
    throw_s3_error(doing, location_, answer, refusal_of(answer));
}

std::optional<S3Object> S3Client::find(const std::string& key) {
    const HttpAnswer answer = send({.method = "HEAD", .key = key});
    if (answer.status == 404) return std::nullopt;
    const std::string doing = "looking for " + key;
    if (answer.status != 200) {
        if (answer.status != 0)  // an answer to HEAD has no body that says why
            require(doing, {.method = "GET", .key = key, .headers = {{"range", "bytes=0-0"}}});
        throw_s3_error(doing, location_, answer, {});
    }
    S3Object object{.size_bytes = -1, .etag = header(answer, "etag")};
    const std::string size = header(answer, "content-length");
    std::from_chars(size.data(), size.data() + size.size(), object.size_bytes);
    if (object.size_bytes < 0)
        throw Error(ErrorCode::Unavailable, doing + ": the object store does not say its size");
    return object;
}

std::string S3Client::get(const std::string& key,
                          const std::string& etag,
                          std::int64_t offset,
                          std::size_t size) {
    const std::int64_t last = offset + static_cast<std::int64_t>(size) - 1;
    Request request{
        .method = "GET",
        .key = key,
        .headers = {{"range", "bytes=" + std::to_string(offset) + '-' + std::to_string(last)}},
        .max_answer_bytes = std::max(size, kMaxAnswerBytes)};
    if (!etag.empty()) request.headers["if-match"] = etag;
    HttpAnswer answer = require("reading " + key, request);
    const std::string range = header(answer, "content-range");
    const bool is_asked_for =
        answer.status == 206
            ? range.starts_with("bytes " + std::to_string(offset) + '-' + std::to_string(last))
            : offset == 0;
    if (!is_asked_for || answer.body.size() != size)
        throw Error(ErrorCode::Unavailable,
                    "reading " + key + " in " + location_.text() +
                        ": the object store sent other bytes than were asked for");
    return std::move(answer.body);
}

std::optional<std::string> S3Client::get_small(const std::string& key, std::size_t max_bytes) {
    Request request{.method = "GET", .key = key};
    HttpAnswer answer = try_once(request, sha256_hex(""));
    const S3Refusal refusal = refusal_of(answer);
    if (answer.status == 404 && refusal.code != "NoSuchBucket") return std::nullopt;
    if (answer.status != 200) throw_s3_error("reading " + key, location_, answer, refusal);
    if (answer.body.size() > max_bytes) answer.body.resize(max_bytes);
    return std::move(answer.body);
}

void S3Client::put(const std::string& key, const HttpBody& body) {
    require("writing " + key, {.method = "PUT", .key = key, .body = body});
}

void S3Client::remove(const std::string& key) {
    const Request request{.method = "DELETE", .key = key};
    const HttpAnswer answer = send(request);
    const S3Refusal refusal = refusal_of(answer);
    const bool is_gone = answer.status == 404 && refusal.code != "NoSuchBucket";
    if (is_gone || (answer.status >= 200 && answer.status < 300)) return;
    throw_s3_error("removing " + key, location_, answer, refusal);
}

void S3Client::remove(const std::vector<std::string>& keys) {
    std::string text = "<Delete><Quiet>true</Quiet>";
    for (const std::string& key : keys) text += "<Object><Key>" + escaped(key) + "</Key></Object>";
    text += "</Delete>";
    const std::string doing = "removing " + std::to_string(keys.size()) + " objects";
    const HttpAnswer answer = require(doing,
                                      {.method = "POST",
                                       .key = "",
                                       .query = {{"delete", ""}},
                                       .headers = {{"content-md5", base64(md5_of(text))}},
                                       .body = body_of(text)});
    if (answer.body.empty()) return;
    for (const XmlNode& node : parse_xml(answer.body).children)
        if (node.name == "Error")
            throw Error(ErrorCode::Unavailable,
                        doing + " in " + location_.text() + ": " + node.text_of("Code") +
                            ": check what the key may do in the bucket");
}

S3Listing S3Client::list(const std::string& prefix, bool by_folder) {
    S3Listing listing;
    Request request{
        .method = "GET",
        .key = "",
        .query = {
            {"list-type", "2"}, {"max-keys", std::to_string(kMaxKeysAtATime)}, {"prefix", prefix}}};
    if (by_folder) request.query["delimiter"] = "/";
    for (;;) {
        const HttpAnswer answer = require("listing " + prefix, request);
        const XmlNode page = parse_xml(answer.body);
        for (const XmlNode& node : page.children) {
            if (node.name == "Contents") {
                listing.names.push_back(without_prefix(node.text_of("Key"), prefix));
            } else if (node.name == "CommonPrefixes") {
                std::string folder = without_prefix(node.text_of("Prefix"), prefix);
                if (folder.ends_with('/')) folder.pop_back();
                listing.folders.push_back(std::move(folder));
            }
        }
        const std::string next = page.text_of("NextContinuationToken");
        if (page.text_of("IsTruncated") != "true" || next.empty()) return listing;
        if (listing.names.size() + listing.folders.size() > kMaxNames)
            throw Error(ErrorCode::TooLarge, prefix + " has too many objects to list");
        request.query["continuation-token"] = next;
    }
}

std::string S3Client::begin_upload(const std::string& key) {
    const std::string doing = "beginning to write " + key;
    const HttpAnswer answer =
        require(doing, {.method = "POST", .key = key, .query = {{"uploads", ""}}});
    std::string id = parse_xml(answer.body).text_of("UploadId");
    if (id.empty()) throw Error(ErrorCode::Unavailable, doing + ": the object store names no id");
    return id;
}

std::string S3Client::put_part(const std::string& key, const S3Part& part, const HttpBody& body) {
    const HttpAnswer answer = require(
        "writing " + key,
        {.method = "PUT",
         .key = key,
         .query = {{"partNumber", std::to_string(part.number)}, {"uploadId", part.upload_id}},
         .body = body});
    std::string etag = header(answer, "etag");
    if (etag.empty())
        throw Error(ErrorCode::Unavailable, "writing " + key + ": the object store names no ETag");
    return etag;
}

// A store may answer 200 before it knows, and say in the body that it failed. The answer to a
// request that succeeded may have been lost: the next one then fails, and the object is there.
void S3Client::complete_upload(const std::string& key,
                               const std::string& id,
                               const std::vector<std::string>& etags,
                               std::int64_t size_bytes) {
    const Request request{.method = "POST",
                          .key = key,
                          .query = {{"uploadId", id}},
                          .body = body_of(completion_of(etags))};
    const std::string sha256 = sha256_of(request.body);
    const std::string etag = etag_of_parts(etags);
    Patience patience(settings_.patience);
    for (;;) {
        const HttpAnswer answer = try_once(request, sha256);
        const S3Refusal refusal = refusal_of(answer);
        const bool is_done = answer.status == 200 && refusal.code.empty() && !answer.body.empty();
        const auto object = find(key);
        const bool is_there = object && object->size_bytes == size_bytes;
        if (is_there && (is_done || (!etag.empty() && object->etag == etag))) return;
        if (is_done)
            throw Error(ErrorCode::Unavailable,
                        "completing " + key + " in " + location_.text() +
                            ": the object store has made an object of another size: try again");
        if (!may_pass(answer, refusal) || !patience.waits())
            throw_s3_error("completing " + key, location_, answer, refusal);
    }
}

void S3Client::abort_upload(const std::string& key, const std::string& id) {
    const HttpAnswer answer = send({.method = "DELETE", .key = key, .query = {{"uploadId", id}}});
    if (answer.status == 404 || (answer.status >= 200 && answer.status < 300)) return;
    throw_s3_error("giving up to write " + key, location_, answer, refusal_of(answer));
}

std::vector<S3OpenUpload> S3Client::open_uploads(const std::string& prefix) {
    const HttpAnswer answer =
        require("listing unfinished uploads",
                {.method = "GET", .key = "", .query = {{"prefix", prefix}, {"uploads", ""}}});
    std::vector<S3OpenUpload> uploads;
    for (const XmlNode& node : parse_xml(answer.body).children) {
        if (node.name != "Upload") continue;
        S3OpenUpload upload{
            node.text_of("Key"), node.text_of("UploadId"), node.text_of("Initiated")};
        if (upload.key.starts_with(prefix)) uploads.push_back(std::move(upload));
    }
    return uploads;
}

}  // namespace divemesh::storage
