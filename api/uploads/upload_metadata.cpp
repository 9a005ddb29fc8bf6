#include "api/uploads/upload_metadata.hpp"

#include <algorithm>

#include "schemas/base64.hpp"
#include "schemas/error.hpp"
#include "schemas/reconstruction_options.hpp"
#include "schemas/trimmed.hpp"

namespace divemesh::api {
namespace {

constexpr std::size_t kMaxNameBytes = 200;

[[noreturn]] void refuse(const std::string& why) {
    throw Error(ErrorCode::InvalidArgument, "Upload-Metadata: " + why);
}

std::string from_base64(std::string_view text) {
    auto bytes = decode_base64(text);
    if (!bytes) refuse("a value is not base64");
    return std::move(*bytes);
}

// Returns a readable name: no folders, no control characters, cut between characters of UTF-8.
std::string plain_name(std::string name) {
    name.erase(0, name.find_last_of("/\\") + 1);
    std::erase_if(name, [](unsigned char c) { return c < 0x20 || c == 0x7f; });
    if (name.size() <= kMaxNameBytes) return name;
    std::size_t end = kMaxNameBytes;
    while (end > 0 && (static_cast<unsigned char>(name[end]) & 0xc0) == 0x80) --end;
    return name.substr(0, end);
}

}  // namespace

std::map<std::string, std::string> parse_upload_metadata(std::string_view header) {
    std::map<std::string, std::string> metadata;
    if (trimmed(header).empty()) return metadata;
    for (std::size_t start = 0; start <= header.size();) {
        const auto end = std::min(header.find(',', start), header.size());
        const auto pair = trimmed(header.substr(start, end - start));
        start = end + 1;
        const std::string key(pair.substr(0, pair.find(' ')));
        if (key.empty()) refuse("a key is empty");
        if (std::any_of(key.begin(), key.end(), [](char c) { return c < 0x21 || c > 0x7e; }))
            refuse("a key is not printable ASCII");
        const auto value = trimmed(pair.substr(key.size()));
        if (!metadata.emplace(key, value.empty() ? "" : from_base64(value)).second)
            refuse("the key \"" + key + "\" occurs twice");
    }
    return metadata;
}

void check_sha256(const std::string& text, const std::string& what) {
    const bool hex = text.size() == 64 && std::all_of(text.begin(), text.end(), [](char c) {
                         return (c >= '0' && c <= '9') || (c >= 'a' && c <= 'f');
                     });
    if (!hex) throw Error(ErrorCode::InvalidArgument, what + " must be 64 lower-case hex digits");
}

UploadPlan plan_of(std::string_view header) {
    const auto metadata = parse_upload_metadata(header);
    const auto value = [&](const char* key) {
        const auto found = metadata.find(key);
        return found == metadata.end() ? std::string() : found->second;
    };
    UploadPlan plan{plain_name(value("filename")), value("sha256"), value("dive"), value("job")};
    plan.commit = metadata.contains("job") || metadata.contains("commit");
    if (!plan.archive_sha256.empty()) check_sha256(plan.archive_sha256, "sha256");
    if (!plan.content_sha256.empty()) check_sha256(plan.content_sha256, "dive");
    if (metadata.contains("job")) preset_options(plan.preset);
    if (!metadata.contains("truth")) return plan;
    plan.truth = truth_kind_from_string(value("truth"));
    plan.dive_id = value("dive_id");
    plan.commit = true;
    if (plan.dive_id.empty()) refuse("truth needs dive_id: give the id of its dive");
    if (metadata.contains("job")) refuse("a truth file is not reconstructed: leave out job");
    return plan;
}

}  // namespace divemesh::api
