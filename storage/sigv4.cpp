#include "storage/sigv4.hpp"

#include <openssl/evp.h>
#include <openssl/hmac.h>
#include <stdexcept>

#include "schemas/content_hash.hpp"

namespace divemesh::storage {
namespace {

constexpr std::string_view kAlgorithm = "AWS4-HMAC-SHA256";
constexpr std::string_view kHexDigits = "0123456789abcdef";
constexpr std::string_view kEncodingDigits = "0123456789ABCDEF";

std::string hmac_sha256(std::string_view key, std::string_view text) {
    std::string mac(EVP_MAX_MD_SIZE, '\0');
    unsigned size = 0;
    if (HMAC(EVP_sha256(),
             key.data(),
             static_cast<int>(key.size()),
             reinterpret_cast<const unsigned char*>(text.data()),
             text.size(),
             reinterpret_cast<unsigned char*>(mac.data()),
             &size) == nullptr)
        throw std::runtime_error("HMAC failed");
    mac.resize(size);
    return mac;
}

bool stays(char c) {
    return (c >= 'A' && c <= 'Z') || (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '-' ||
           c == '.' || c == '_' || c == '~';
}

std::string names_of(const std::map<std::string, std::string>& headers) {
    std::string names;
    for (const auto& [name, value] : headers) {
        if (!names.empty()) names += ';';
        names += name;
    }
    return names;
}

std::string canonical_request(const SignedParts& parts, const std::string& payload_sha256) {
    std::string text = parts.method + '\n' + percent_encoded(parts.path, true) + '\n' +
                       canonical_query(parts.query) + '\n';
    for (const auto& [name, value] : parts.headers)
        text.append(name).append(":").append(value).append("\n");
    return text + '\n' + names_of(parts.headers) + '\n' + payload_sha256;
}

// Returns the key that signs the requests of one day to one region.
std::string signing_key(const std::string& secret_key,
                        const std::string& day,
                        const std::string& region) {
    const std::string of_day = hmac_sha256("AWS4" + secret_key, day);
    const std::string of_region = hmac_sha256(of_day, region);
    return hmac_sha256(hmac_sha256(of_region, "s3"), "aws4_request");
}

}  // namespace

std::string to_hex(std::string_view bytes) {
    std::string text;
    for (const char byte : bytes) {
        text += kHexDigits[static_cast<unsigned char>(byte) >> 4];
        text += kHexDigits[static_cast<unsigned char>(byte) & 15];
    }
    return text;
}

std::string percent_encoded(std::string_view text, bool keep_slash) {
    std::string encoded;
    for (const char c : text) {
        if (stays(c) || (keep_slash && c == '/')) {
            encoded += c;
            continue;
        }
        encoded += '%';
        encoded += kEncodingDigits[static_cast<unsigned char>(c) >> 4];
        encoded += kEncodingDigits[static_cast<unsigned char>(c) & 15];
    }
    return encoded;
}

std::string canonical_query(const std::map<std::string, std::string>& query) {
    std::string text;
    for (const auto& [name, value] : query) {
        if (!text.empty()) text += '&';
        text += percent_encoded(name) + '=' + percent_encoded(value);
    }
    return text;
}

std::string sigv4_authorization(const SignedParts& parts,
                                const S3Credentials& credentials,
                                const std::string& region,
                                const std::string& time,
                                const std::string& payload_sha256) {
    const std::string day = time.substr(0, time.find('T'));
    const std::string scope = day + '/' + region + "/s3/aws4_request";
    const std::string text = std::string(kAlgorithm) + '\n' + time + '\n' + scope + '\n' +
                             sha256_hex(canonical_request(parts, payload_sha256));
    const std::string signature =
        to_hex(hmac_sha256(signing_key(credentials.secret_key, day, region), text));
    return std::string(kAlgorithm) + " Credential=" + credentials.access_key + '/' + scope +
           ",SignedHeaders=" + names_of(parts.headers) + ",Signature=" + signature;
}

}  // namespace divemesh::storage
