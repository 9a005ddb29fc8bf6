#include "api/webhook_signature.hpp"

#include <charconv>
#include <openssl/evp.h>
#include <openssl/hmac.h>
#include <stdexcept>
#include <vector>

namespace divemesh::api {
namespace {

constexpr std::string_view kPrefix = "whsec_";

std::string to_base64(const std::vector<unsigned char>& bytes) {
    std::string text(4 * ((bytes.size() + 2) / 3) + 1, '\0');
    const int size = EVP_EncodeBlock(reinterpret_cast<unsigned char*>(text.data()),
                                     bytes.data(),
                                     static_cast<int>(bytes.size()));
    text.resize(static_cast<std::size_t>(size));
    return text;
}

// Decodes a secret of webhook_secret(): its length is a multiple of four.
std::vector<unsigned char> from_base64(std::string_view text) {
    std::vector<unsigned char> bytes(text.size() / 4 * 3);
    const int size = EVP_DecodeBlock(bytes.data(),
                                     reinterpret_cast<const unsigned char*>(text.data()),
                                     static_cast<int>(text.size()));
    if (size < 0) throw std::runtime_error("a webhook's secret is not base64");
    const auto padding = text.size() - text.find_last_not_of('=') - 1;
    bytes.resize(static_cast<std::size_t>(size) - padding);
    return bytes;
}

}  // namespace

std::string webhook_secret(std::string_view random_hex) {
    std::vector<unsigned char> bytes(random_hex.size() / 2);
    for (std::size_t i = 0; i < bytes.size(); ++i)
        std::from_chars(random_hex.data() + 2 * i, random_hex.data() + 2 * i + 2, bytes[i], 16);
    return std::string(kPrefix) + to_base64(bytes);
}

std::string webhook_signature(std::string_view secret,
                              std::string_view id,
                              std::int64_t timestamp_s,
                              std::string_view body) {
    if (secret.starts_with(kPrefix)) secret.remove_prefix(kPrefix.size());
    const auto key = from_base64(secret);
    const std::string text =
        std::string(id) + "." + std::to_string(timestamp_s) + "." + std::string(body);
    std::vector<unsigned char> mac(EVP_MAX_MD_SIZE);
    unsigned size = 0;
    if (HMAC(EVP_sha256(),
             key.data(),
             static_cast<int>(key.size()),
             reinterpret_cast<const unsigned char*>(text.data()),
             text.size(),
             mac.data(),
             &size) == nullptr)
        throw std::runtime_error("HMAC failed");
    mac.resize(size);
    return "v1," + to_base64(mac);
}

}  // namespace divemesh::api
