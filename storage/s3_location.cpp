#include "storage/s3_location.hpp"

#include <algorithm>
#include <curl/curl.h>
#include <memory>
#include <string_view>

#include "schemas/error.hpp"
#include "storage/blob_key.hpp"

namespace divemesh::storage {
namespace {

constexpr std::string_view kScheme = "s3://";
constexpr std::size_t kMinBucketBytes = 3;
constexpr std::size_t kMaxBucketBytes = 63;

[[noreturn]] void refuse(const std::string& what) {
    throw Error(ErrorCode::InvalidArgument,
                "--blobs: " + what +
                    ": give s3://bucket[/prefix]?endpoint=https://host[:port]&region=NAME");
}

class Url {
public:
    explicit Url(const std::string& text) : url_(curl_url(), curl_url_cleanup) {
        if (curl_url_set(url_.get(), CURLUPART_URL, text.c_str(), CURLU_NON_SUPPORT_SCHEME) !=
            CURLUE_OK)
            refuse("cannot read the address");
    }
    // Returns a part; "" if there is none.
    std::string part(CURLUPart which) const {
        char* text = nullptr;
        if (curl_url_get(url_.get(), which, &text, 0) != CURLUE_OK) return "";
        const std::unique_ptr<char, void (*)(void*)> owned(text, curl_free);
        return text;
    }

private:
    std::unique_ptr<CURLU, void (*)(CURLU*)> url_;
};

std::string decoded(const std::string& text) {
    int size = 0;
    const std::unique_ptr<char, void (*)(void*)> plain(
        curl_easy_unescape(nullptr, text.c_str(), static_cast<int>(text.size()), &size), curl_free);
    if (!plain) refuse("cannot read " + text);
    return {plain.get(), static_cast<std::size_t>(size)};
}

bool is_word(std::string_view text, std::string_view others) {
    return !text.empty() && std::all_of(text.begin(), text.end(), [&](char c) {
        return (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') ||
               others.find(c) != std::string_view::npos;
    });
}

std::string checked_endpoint(const std::string& text) {
    const Url url(text);
    const std::string scheme = url.part(CURLUPART_SCHEME);
    if (scheme != "http" && scheme != "https") refuse("the endpoint is no http or https address");
    if (!url.part(CURLUPART_USER).empty() || !url.part(CURLUPART_PASSWORD).empty())
        refuse(
            "no keys belong into the address, which others see: set AWS_ACCESS_KEY_ID and "
            "AWS_SECRET_ACCESS_KEY");
    if (url.part(CURLUPART_PATH) != "/" || !url.part(CURLUPART_QUERY).empty())
        refuse("the endpoint has a path");
    const std::string port = url.part(CURLUPART_PORT);
    return scheme + "://" + url.part(CURLUPART_HOST) + (port.empty() ? "" : ":" + port);
}

void take_parameter(S3Location& location, const std::string& text) {
    const auto equals = std::min(text.find('='), text.size());
    const std::string name = text.substr(0, equals);
    const std::string value = equals < text.size() ? decoded(text.substr(equals + 1)) : "";
    if (name == "endpoint") {
        location.endpoint = checked_endpoint(value);
    } else if (name == "region") {
        if (!is_word(value, "-")) refuse("the region is made of a-z 0-9 -");
        location.region = value;
    } else if (name == "style") {
        if (value != "path" && value != "host") refuse("style is path or host");
        location.path_style = value == "path";
    } else {
        refuse("there is no parameter " + name);
    }
}

}  // namespace

bool is_s3_url(const std::string& url) { return url.starts_with(kScheme); }

S3Location parse_s3_url(const std::string& url) {
    if (!is_s3_url(url)) refuse("this is no address of an object store");
    const std::string rest = url.substr(kScheme.size());
    const auto question = std::min(rest.find('?'), rest.size());
    const std::string place = rest.substr(0, question);
    const auto slash = std::min(place.find('/'), place.size());
    S3Location location;
    location.bucket = place.substr(0, slash);
    const auto size = location.bucket.size();
    if (!is_word(location.bucket, ".-") || size < kMinBucketBytes || size > kMaxBucketBytes)
        refuse("a bucket's name has 3 to 63 of a-z 0-9 . -");
    if (slash + 1 < place.size()) {
        std::string prefix = place.substr(slash + 1);
        if (prefix.ends_with('/')) prefix.pop_back();
        split_key(prefix);
        location.prefix = prefix + '/';
    }
    location.path_style = rest.find("endpoint=", question) != std::string::npos;
    for (std::size_t begin = question + 1; begin < rest.size();) {
        const auto end = std::min(rest.find('&', begin), rest.size());
        take_parameter(location, rest.substr(begin, end - begin));
        begin = end + 1;
    }
    if (location.endpoint.empty())
        location.endpoint = "https://s3." + location.region + ".amazonaws.com";
    return location;
}

std::string S3Location::scheme() const { return endpoint.substr(0, endpoint.find(':')); }

std::string S3Location::host() const {
    const std::string given = endpoint.substr(endpoint.find("://") + 3);
    return path_style ? given : bucket + '.' + given;
}

std::string S3Location::path(const std::string& key) const {
    const std::string root = path_style ? '/' + bucket : "";
    return key.empty() && path_style ? root : root + '/' + key;
}

std::string S3Location::text() const {
    return std::string(kScheme) + bucket + '/' + prefix + " at " + endpoint;
}

}  // namespace divemesh::storage
