#include "api/client/dive_tar.hpp"

#include <algorithm>

#include "api/client/folder_listing.hpp"
#include "api/client/tar_header.hpp"
#include "schemas/content_hash.hpp"
#include "schemas/error.hpp"

namespace divemesh::api::client {
namespace {

namespace fs = std::filesystem;

constexpr std::int64_t kEndBytes = 2 * kTarBlockBytes;  // a tar ends with two empty blocks
constexpr std::size_t kReadBytes = std::size_t{1} << 20;

// Returns the part of `buffer` that the `left` bytes fill.
std::span<char> first_bytes(std::span<char> buffer, std::int64_t left) {
    return buffer.first(static_cast<std::size_t>(
        std::min<std::int64_t>(static_cast<std::int64_t>(buffer.size()), left)));
}

}  // namespace

DiveTar::DiveTar(const fs::path& folder, Links links, TarOf of)
    : folder_(fs::canonical(folder)), links_(links) {
    list_files(of);
    lay_out();
}

void DiveTar::list_files(TarOf of) {
    FolderListing listing = list_folder(folder_, links_);
    left_out_ = std::move(listing.left_out);
    const auto root = find_dive_root(listing.files);
    is_dive_ = of == TarOf::Dive && root && root->strip.empty();
    if (!is_dive_ && (of == TarOf::Dive || listing.files.empty())) {
        std::string problem = folder_.string() + " contains neither mav0 nor cam0";
        if (!left_out_.empty())
            problem += " (" + left_out_.front() + " is left out: a link or a special file)";
        throw Error(ErrorCode::NotFound, problem + ": give the folder of the dive");
    }
    const std::string prefix = is_dive_ ? root->prefix : "";
    for (const auto& name : listing.files) {
        const fs::path source(name);
        files_.push_back({prefix + name, source, stamp_of(folder_ / source, links_)});
    }
}

void DiveTar::lay_out() {
    std::sort(
        files_.begin(), files_.end(), [](const File& a, const File& b) { return a.name < b.name; });
    for (auto& file : files_) {
        file.offset = size_bytes_;
        size_bytes_ +=
            static_cast<std::int64_t>(tar_header(file.name, file.stamp.size_bytes).size()) +
            file.stamp.size_bytes + tar_padding_bytes(file.stamp.size_bytes);
    }
    size_bytes_ += kEndBytes;
}

std::size_t DiveTar::read_at(std::int64_t offset, std::span<char> buffer) {
    if (offset >= size_bytes_ || buffer.empty()) return 0;
    const auto after =
        std::upper_bound(files_.begin(), files_.end(), offset, [](std::int64_t at, const File& f) {
            return at < f.offset;
        });
    if (after == files_.begin()) return 0;
    const File& file = *(after - 1);
    const std::string header = tar_header(file.name, file.stamp.size_bytes);
    std::int64_t at = offset - file.offset;
    if (at < static_cast<std::int64_t>(header.size())) {
        const auto part = first_bytes(buffer, static_cast<std::int64_t>(header.size()) - at);
        std::copy_n(header.begin() + at, part.size(), part.begin());
        return part.size();
    }
    at -= static_cast<std::int64_t>(header.size());
    if (at < file.stamp.size_bytes) return read_content(file, at, buffer);
    const std::int64_t end = after == files_.end() ? size_bytes_ : after->offset;
    const auto zeros = first_bytes(buffer, end - offset);
    std::fill(zeros.begin(), zeros.end(), '\0');
    return zeros.size();
}

std::size_t DiveTar::read_content(const File& file, std::int64_t offset, std::span<char> buffer) {
    const auto part = first_bytes(buffer, file.stamp.size_bytes - offset);
    const std::size_t count = open(file).read_at(offset, part);
    if (count == 0)
        throw Error(ErrorCode::Conflict,
                    file.source.string() + " became shorter while it was read: start again");
    return count;
}

const OpenFile& DiveTar::open(const File& file) {
    if (open_of_ != &file) {
        open_of_ = nullptr;
        open_ = std::make_unique<OpenFile>(folder_, file.source, links_);
        if (open_->stamp() != file.stamp)
            throw Error(ErrorCode::Conflict,
                        file.source.string() + " changed since the upload started: start again");
        open_of_ = &file;
    }
    return *open_;
}

DiveHashes DiveTar::hash(const BytesDone& bytes_done) {
    Sha256 archive;
    std::vector<HashedFile> contents;
    std::vector<char> buffer(kReadBytes);
    for (const auto& file : files_) {
        archive.update(tar_header(file.name, file.stamp.size_bytes));
        Sha256 content;
        for (std::int64_t at = 0; at < file.stamp.size_bytes;) {
            const std::span<char> part(buffer.data(), read_content(file, at, buffer));
            archive.update(part);
            content.update(part);
            at += static_cast<std::int64_t>(part.size());
        }
        archive.update(
            std::string(static_cast<std::size_t>(tar_padding_bytes(file.stamp.size_bytes)), '\0'));
        contents.push_back({file.name, content.hex()});
        bytes_done(file.offset + file.stamp.size_bytes);
    }
    archive.update(std::string(kEndBytes, '\0'));
    return {archive.hex(), is_dive_ ? content_sha256(std::move(contents)) : ""};
}

DiveHashes hash_archive(ByteSource& archive, const BytesDone& bytes_done) {
    Sha256 hash;
    std::vector<char> buffer(kReadBytes);
    for (std::int64_t at = 0; at < archive.size_bytes();) {
        const std::span<char> part(buffer.data(), archive.read_at(at, buffer));
        hash.update(part);
        at += static_cast<std::int64_t>(part.size());
        bytes_done(at);
    }
    return {hash.hex(), ""};
}

}  // namespace divemesh::api::client
