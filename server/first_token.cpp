#include "server/first_token.hpp"

#include <cerrno>
#include <cstring>
#include <fcntl.h>
#include <unistd.h>

#include "api/audit.hpp"
#include "schemas/error.hpp"
#include "schemas/file_descriptor.hpp"
#include "storage/token_store.hpp"

namespace divemesh::server {
namespace {

void write_secret(const std::filesystem::path& file, const std::string& secret) {
    const std::filesystem::path part = file.string() + ".part";
    unlink(part.c_str());
    const std::string line = secret + "\n";
    FileDescriptor opened(open(part.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0600));
    if (opened.is_open() &&
        write(opened.get(), line.data(), line.size()) == static_cast<ssize_t>(line.size()) &&
        fsync(opened.get()) == 0 && opened.close() && rename(part.c_str(), file.c_str()) == 0)
        return;
    const int failure = errno;
    throw Error(ErrorCode::Unavailable,
                "cannot write the first token to " + file.string() + ": " + std::strerror(failure));
}

}  // namespace

std::string make_first_token(const storage::Catalog& catalog, const std::filesystem::path& file) {
    auto noted = api::audited(catalog, "serve", "first token");
    storage::TokenStore tokens(noted);
    if (!tokens.empty()) return "";
    const auto created = tokens.create({.name = "first", .scopes = {"admin"}});
    try {
        write_secret(file, created.secret);
    } catch (const Error&) {
        auto withdrawn =
            api::audited(catalog, "serve", "first token withdrawn: it was never shown");
        storage::TokenStore(withdrawn).revoke(created.token.id);
        throw;
    }
    return created.secret;
}

}  // namespace divemesh::server
