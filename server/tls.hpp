#pragma once

#include <boost/asio/ssl/context.hpp>
#include <filesystem>
#include <memory>
#include <mutex>

namespace divemesh::server {

// The server's certificate, read again on demand; open connections keep the one they began with.
// TLS 1.2 and later, no renegotiation. Thread-safe.
class TlsCertificate {
public:
    // Both empty: no TLS. Throws Error{InvalidArgument}, which names the file that is missing,
    // cannot be read or does not fit the other.
    TlsCertificate(std::filesystem::path certificate, std::filesystem::path key);

    void reload();  // throws as the constructor does and keeps the old certificate
    std::shared_ptr<boost::asio::ssl::context> current() const;  // null: no TLS

private:
    std::filesystem::path certificate_;
    std::filesystem::path key_;
    mutable std::mutex mutex_;
    std::shared_ptr<boost::asio::ssl::context> current_;
};

}  // namespace divemesh::server
