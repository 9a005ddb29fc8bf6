#include "server/tls.hpp"

#include "schemas/error.hpp"

namespace divemesh::server {
namespace {

namespace ssl = boost::asio::ssl;

[[noreturn]] void refuse(const std::filesystem::path& file, const std::string& why) {
    throw Error(ErrorCode::InvalidArgument, "cannot use " + file.string() + ": " + why);
}

std::shared_ptr<ssl::context> load(const std::filesystem::path& certificate,
                                   const std::filesystem::path& key) {
    auto context = std::make_shared<ssl::context>(ssl::context::tls_server);
    SSL_CTX_set_min_proto_version(context->native_handle(), TLS1_2_VERSION);
    SSL_CTX_set_options(context->native_handle(), SSL_OP_NO_RENEGOTIATION);
    // Allows of TLS 1.2 only authenticated encryption with forward secrecy (RFC 9325, 4.2).
    SSL_CTX_set_cipher_list(context->native_handle(), "ECDHE+AESGCM:ECDHE+CHACHA20");
    boost::system::error_code failure;
    context->use_certificate_chain_file(certificate.string(), failure);
    if (failure) refuse(certificate, "it is not a PEM certificate chain: " + failure.message());
    context->use_private_key_file(key.string(), ssl::context::pem, failure);
    if (failure)
        refuse(key, "it is not a PEM key, or not the key of the certificate: " + failure.message());
    return context;
}

}  // namespace

TlsCertificate::TlsCertificate(std::filesystem::path certificate, std::filesystem::path key)
    : certificate_(std::move(certificate)), key_(std::move(key)) {
    if (certificate_.empty() != key_.empty())
        throw Error(ErrorCode::InvalidArgument,
                    "TLS needs both a certificate and its key: give --tls-cert and --tls-key");
    reload();
}

void TlsCertificate::reload() {
    if (certificate_.empty()) return;
    auto fresh = load(certificate_, key_);
    const std::lock_guard lock(mutex_);
    current_ = std::move(fresh);
}

std::shared_ptr<ssl::context> TlsCertificate::current() const {
    const std::lock_guard lock(mutex_);
    return current_;
}

}  // namespace divemesh::server
