#include "schemas/content_hash.hpp"

#include <algorithm>
#include <array>
#include <new>
#include <openssl/evp.h>
#include <stdexcept>

#include "schemas/desktop_files.hpp"
#include "schemas/error.hpp"

namespace divemesh {
namespace {

void check(int openssl_result) {
    if (openssl_result != 1) throw std::runtime_error("OpenSSL cannot compute SHA-256");
}

evp_md_ctx_st* new_context() {
    auto* context = EVP_MD_CTX_new();
    if (context == nullptr) throw std::bad_alloc();
    return context;
}

// Returns what precedes the first folder called `name`; nullopt if there is none.
std::optional<std::string_view> before_folder(std::string_view path, std::string_view name) {
    std::size_t start = 0;
    while (true) {
        const std::size_t slash = path.find('/', start);
        if (slash == std::string_view::npos) return std::nullopt;
        if (path.substr(start, slash - start) == name) return path.substr(0, start);
        start = slash + 1;
    }
}

std::optional<std::string> shallowest_with(const std::vector<std::string>& paths,
                                           std::string_view folder) {
    const auto depth = [](std::string_view path) {
        return std::count(path.begin(), path.end(), '/');
    };
    std::optional<std::string> best;
    for (const auto& path : paths) {
        const auto root = before_folder(path, folder);
        if (!root) continue;
        if (!best || depth(*root) < depth(*best) || (depth(*root) == depth(*best) && *root < *best))
            best = std::string(*root);
    }
    return best;
}

}  // namespace

Sha256::Sha256() : context_(new_context(), &EVP_MD_CTX_free) {
    check(EVP_DigestInit_ex(context_.get(), EVP_sha256(), nullptr));
}

Sha256::~Sha256() = default;
Sha256::Sha256(Sha256&&) noexcept = default;
Sha256& Sha256::operator=(Sha256&&) noexcept = default;

Sha256::Sha256(const Sha256& other) : context_(new_context(), &EVP_MD_CTX_free) {
    check(EVP_MD_CTX_copy_ex(context_.get(), other.context_.get()));
}

Sha256& Sha256::operator=(const Sha256& other) {
    if (this != &other) check(EVP_MD_CTX_copy_ex(context_.get(), other.context_.get()));
    return *this;
}

void Sha256::update(std::span<const char> bytes) {
    check(EVP_DigestUpdate(context_.get(), bytes.data(), bytes.size()));
}

std::string Sha256::hex() const {
    const Sha256 copy(*this);  // finishing ends a context
    std::array<unsigned char, 32> digest{};
    check(EVP_DigestFinal_ex(copy.context_.get(), digest.data(), nullptr));
    constexpr char kDigits[] = "0123456789abcdef";
    std::string text;
    text.reserve(2 * digest.size());
    for (const unsigned char byte : digest) {
        text += kDigits[byte >> 4];
        text += kDigits[byte & 15];
    }
    return text;
}

std::string sha256_hex(std::string_view bytes) {
    Sha256 hash;
    hash.update(bytes);
    return hash.hex();
}

std::optional<DiveRoot> find_dive_root(const std::vector<std::string>& paths) {
    if (auto root = shallowest_with(paths, "mav0")) return DiveRoot{std::move(*root), ""};
    if (auto root = shallowest_with(paths, "cam0")) return DiveRoot{std::move(*root), "mav0/"};
    return std::nullopt;
}

std::optional<std::string> path_in_dive(const DiveRoot& root, std::string_view path) {
    if (!path.starts_with(root.strip)) return std::nullopt;
    return root.prefix + std::string(path.substr(root.strip.size()));
}

namespace {

std::string sha256_of_list(std::vector<HashedFile> files) {
    std::sort(files.begin(), files.end(), [](const HashedFile& a, const HashedFile& b) {
        return a.path < b.path;  // std::string compares as unsigned bytes
    });
    Sha256 hash;
    const std::string* previous = nullptr;
    for (const auto& file : files) {
        if (previous != nullptr && *previous == file.path)
            throw Error(ErrorCode::BadData,
                        "the dive has two files named " + file.path + ": remove one");
        if (file.path.find('\n') != std::string::npos)
            throw Error(ErrorCode::BadData,
                        "a file name of the dive contains a line break: rename the file");
        hash.update(file.sha256);
        hash.update(std::string_view("  "));
        hash.update(file.path);
        hash.update(std::string_view("\n"));
        previous = &file.path;
    }
    return hash.hex();
}

bool is_of_desktop(const HashedFile& file) { return is_left_by_desktop(file.path); }

}  // namespace

std::string content_sha256(std::vector<HashedFile> files) {
    std::erase_if(files, is_of_desktop);
    return sha256_of_list(std::move(files));
}

ContentHash content_hash(const std::vector<HashedFile>& files) {
    ContentHash hash{.sha256 = content_sha256(files)};
    if (std::any_of(files.begin(), files.end(), is_of_desktop))
        hash.with_desktop_files = sha256_of_list(files);
    return hash;
}

bool ContentHash::matches(std::string_view stated) const {
    return !stated.empty() && (stated == sha256 || stated == with_desktop_files);
}

}  // namespace divemesh
