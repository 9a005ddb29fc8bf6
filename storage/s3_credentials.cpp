#include "storage/s3_credentials.hpp"

#include <cstdlib>
#include <fstream>
#include <string_view>

#include "schemas/error.hpp"

namespace divemesh::storage {
namespace {

namespace fs = std::filesystem;
constexpr std::uintmax_t kMaxFileBytes = 64 << 10;

std::string environment(const char* name, const std::string& otherwise = "") {
    const char* value = std::getenv(name);
    return value == nullptr || *value == '\0' ? otherwise : value;
}

std::string_view trimmed(std::string_view text) {
    const auto begin = text.find_first_not_of(" \t\r");
    if (begin == std::string_view::npos) return {};
    return text.substr(begin, text.find_last_not_of(" \t\r") - begin + 1);
}

bool is_usable(const S3Credentials& keys) {
    return !keys.access_key.empty() && !keys.secret_key.empty();
}

}  // namespace

S3Credentials read_s3_credentials(const fs::path& file, const std::string& profile) {
    std::error_code missing;
    const auto size = fs::file_size(file, missing);
    if (missing || size > kMaxFileBytes)
        throw Error(ErrorCode::InvalidArgument,
                    "no keys for the object store: set AWS_ACCESS_KEY_ID and "
                    "AWS_SECRET_ACCESS_KEY, or write them to " +
                        file.string());
    std::ifstream stream(file);
    S3Credentials keys;
    bool is_ours = false;
    for (std::string line; std::getline(stream, line);) {
        const std::string_view text = trimmed(line);
        if (text.starts_with('[')) is_ours = text == '[' + profile + ']';
        const auto equals = text.find('=');
        if (!is_ours || equals == std::string_view::npos) continue;
        const std::string_view name = trimmed(text.substr(0, equals));
        const std::string_view value = trimmed(text.substr(equals + 1));
        if (name == "aws_access_key_id") keys.access_key = value;
        if (name == "aws_secret_access_key") keys.secret_key = value;
        if (name == "aws_session_token") keys.session_token = value;
    }
    if (!is_usable(keys))
        throw Error(ErrorCode::InvalidArgument,
                    file.string() + " has no aws_access_key_id and aws_secret_access_key under [" +
                        profile + "]: write them there, or set AWS_PROFILE");
    return keys;
}

S3Credentials find_s3_credentials() {
    S3Credentials keys{environment("AWS_ACCESS_KEY_ID"),
                       environment("AWS_SECRET_ACCESS_KEY"),
                       environment("AWS_SESSION_TOKEN")};
    if (is_usable(keys)) return keys;
    const std::string usual = environment("HOME", "/") + "/.aws/credentials";
    return read_s3_credentials(environment("AWS_SHARED_CREDENTIALS_FILE", usual),
                               environment("AWS_PROFILE", "default"));
}

}  // namespace divemesh::storage
