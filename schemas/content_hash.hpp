#pragma once

#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

struct evp_md_ctx_st;

namespace divemesh {

// SHA-256 of a stream of bytes. A copy continues from the same state on its own.
class Sha256 {
public:
    Sha256();
    ~Sha256();
    Sha256(const Sha256& other);
    Sha256& operator=(const Sha256& other);
    Sha256(Sha256&&) noexcept;
    Sha256& operator=(Sha256&&) noexcept;

    void update(std::span<const char> bytes);
    std::string hex() const;  // 64 lower-case digits over all bytes so far

private:
    std::unique_ptr<evp_md_ctx_st, void (*)(evp_md_ctx_st*)> context_;
};

// Returns the SHA-256 of bytes as 64 lower-case hex digits.
std::string sha256_hex(std::string_view bytes);

// Where the dive is among the files of a folder or archive. The root is the folder that contains
// mav0/. If mav0 itself was given, "mav0/" is put in front, so both give a file the same name.
struct DiveRoot {
    std::string strip;   // "" or ends with /: the part before the dive's own paths
    std::string prefix;  // "" or "mav0/"
};

// Returns the root: the shallowest folder with a mav0/ (otherwise with a cam0/), the first by bytes
// among equals; nullopt if there is none. `paths` are relative and separated by '/'.
std::optional<DiveRoot> find_dive_root(const std::vector<std::string>& paths);

// Returns "mav0/cam0/data.csv" for "MH_01_easy/mav0/cam0/data.csv"; nullopt for a file outside the
// root.
std::optional<std::string> path_in_dive(const DiveRoot& root, std::string_view path);

struct HashedFile {
    std::string path;    // as path_in_dive() returns it
    std::string sha256;  // lower-case hex
};

// The hashes by which a dive is known.
struct ContentHash {
    std::string sha256;  // of content_sha256(); "" if unknown
    // What earlier versions called its hash: that over all files, also those of desktop_files.hpp;
    // "" if it has none of these.
    std::string with_desktop_files = {};

    // Returns whether `stated`, by this version or an earlier one, is the hash of this dive.
    bool matches(std::string_view stated) const;
    bool operator==(const ContentHash&) const = default;
};

// Returns the identity of a dive, the same for its folder and any archive of it: SHA-256 of one
// line "<sha256>  <path>\n" for every regular file under the root, including hidden ones but no
// links and no desktop_files.hpp, sorted by the bytes of the path. Throws Error{BadData} for a path
// that occurs twice or contains a line end, which could make two dives look alike.
std::string content_sha256(std::vector<HashedFile> files);

// Returns both hashes of a dive. Throws as content_sha256() does.
ContentHash content_hash(const std::vector<HashedFile>& files);

}  // namespace divemesh
