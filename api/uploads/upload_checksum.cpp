#include "api/uploads/upload_checksum.hpp"

#include <new>
#include <openssl/crypto.h>
#include <openssl/evp.h>
#include <stdexcept>

#include "schemas/base64.hpp"
#include "schemas/crc32c.hpp"
#include "schemas/error.hpp"

namespace divemesh::api {
namespace {

constexpr std::size_t kCrcBytes = 4;

const EVP_MD* digest_named(std::string_view name) {
    if (name == "sha1") return EVP_sha1();
    if (name == "sha256") return EVP_sha256();
    if (name == "crc32c") return nullptr;
    throw Error(
        ErrorCode::InvalidArgument,
        "Upload-Checksum has an unknown algorithm: use one of " + std::string(kChecksumAlgorithms));
}

void check(int openssl_result) {
    if (openssl_result != 1) throw std::runtime_error("OpenSSL cannot compute the checksum");
}

}  // namespace

struct UploadChecksum::State {
    std::string expected;
    std::unique_ptr<EVP_MD_CTX, void (*)(EVP_MD_CTX*)> digest{nullptr, &EVP_MD_CTX_free};
    Crc32c crc;  // used if there is no digest
};

UploadChecksum::UploadChecksum(std::string_view header) : state_(std::make_unique<State>()) {
    const auto space = header.find(' ');
    const EVP_MD* digest = digest_named(header.substr(0, space));
    const std::size_t size =
        digest == nullptr ? kCrcBytes : static_cast<std::size_t>(EVP_MD_get_size(digest));
    if (space != std::string_view::npos)
        state_->expected = decode_base64(header.substr(space + 1)).value_or("");
    if (state_->expected.size() != size)
        throw Error(ErrorCode::InvalidArgument,
                    "Upload-Checksum must be the algorithm, a space and " + std::to_string(size) +
                        " bytes in base64");
    if (digest == nullptr) return;
    state_->digest.reset(EVP_MD_CTX_new());
    if (!state_->digest) throw std::bad_alloc();
    check(EVP_DigestInit_ex(state_->digest.get(), digest, nullptr));
}

UploadChecksum::~UploadChecksum() = default;
UploadChecksum::UploadChecksum(UploadChecksum&&) noexcept = default;

void UploadChecksum::update(std::span<const char> bytes) {
    if (state_->digest)
        check(EVP_DigestUpdate(state_->digest.get(), bytes.data(), bytes.size()));
    else
        state_->crc.process_bytes(bytes.data(), bytes.size());
}

bool UploadChecksum::matches() {
    unsigned char digest[EVP_MAX_MD_SIZE] = {};
    if (state_->digest) {
        check(EVP_DigestFinal_ex(state_->digest.get(), digest, nullptr));
    } else {
        for (std::size_t i = 0; i < kCrcBytes; ++i)
            digest[i] = static_cast<unsigned char>(state_->crc.checksum() >> (24 - 8 * i));
    }
    return CRYPTO_memcmp(digest, state_->expected.data(), state_->expected.size()) == 0;
}

}  // namespace divemesh::api
