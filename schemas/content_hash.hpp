#pragma once

#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

struct evp_md_ctx_st;

namespace divemesh {

// SHA-256 of a stream of bytes. A copy goes on from the same state on its own.
class Sha256 {
public:
    Sha256();
    ~Sha256();
    Sha256(const Sha256& other);
    Sha256& operator=(const Sha256& other);
    Sha256(Sha256&&) noexcept;
    Sha256& operator=(Sha256&&) noexcept;

    void update(std::span<const char> bytes);
    std::string hex() const;  // 64 lower-case digits of everything so far

private:
    std::unique_ptr<evp_md_ctx_st, void (*)(evp_md_ctx_st*)> context_;
};

std::string sha256_hex(std::string_view bytes);

// Where the dive is among the files of a folder or archive. The root is the folder that has mav0/;
// where mav0 itself was given, "mav0/" is put in front, so both name a file alike.
struct DiveRoot {
    std::string strip;   // "" or ends with /: what comes before the dive's own paths
    std::string prefix;  // "" or "mav0/"
};

// `paths` are relative and separated by '/'. The shallowest folder with a mav0/ (then one with a
// cam0/) is the root, the first by bytes among equals; nothing when there is neither.
std::optional<DiveRoot> find_dive_root(const std::vector<std::string>& paths);

// "mav0/cam0/data.csv" for "MH_01_easy/mav0/cam0/data.csv"; nothing for a file outside the root.
std::optional<std::string> path_in_dive(const DiveRoot& root, std::string_view path);

struct HashedFile {
    std::string path;    // as path_in_dive() gives it
    std::string sha256;  // lower-case hex
};

// The identity of a dive, the same for its folder and any archive of it: SHA-256 of one line
// "<sha256>  <path>\n" for every regular file under the root, hidden ones included and links left
// out, sorted by the bytes of the path. Throws Error{BadData} for a path that is there twice or
// holds a line end, which could make two dives look alike.
std::string content_sha256(std::vector<HashedFile> files);

}  // namespace divemesh
