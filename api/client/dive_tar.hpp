#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "api/client/byte_source.hpp"
#include "schemas/links.hpp"

namespace divemesh::api::client {

// The two hashes an upload states: of the bytes that are sent, and of the dive's identity.
struct DiveHashes {
    std::string archive_sha256;
    std::string content_sha256;  // "" if only the archive was hashed
};

// Whether a folder is that of a dive, or of images or videos of which a server makes one.
enum class TarOf { Dive, Recording };

using BytesDone = std::function<void(std::int64_t bytes_done)>;

// The tar of a dive's folder, made on the fly. Names are sorted by bytes; times, owners and modes
// are fixed. So the bytes are the same on every machine and can be read from any offset. Names are
// relative to the dive's root (schemas/content_hash.hpp).
class DiveTar : public ByteSource {
public:
    // Lists the folder; reads no file. Throws Error{NotFound} if a dive's has neither mav0/ nor
    // cam0/, or a recording's no file, and Error{TooLarge} if links make more of it than a server
    // accepts.
    DiveTar(const std::filesystem::path& folder, Links links, TarOf of = TarOf::Dive);

    std::int64_t size_bytes() const override { return size_bytes_; }
    std::size_t read_at(std::int64_t offset, std::span<char> buffer) override;

    // Computes both hashes in one pass over every file; of a recording that of the tar alone.
    DiveHashes hash(const BytesDone& bytes_done);

    std::size_t num_files() const { return files_.size(); }
    // Returns the names of what is not sent, sorted, for a warning: special files, links that are
    // left out, and those that lead nowhere or to a folder that they lie in.
    const std::vector<std::string>& left_out() const { return left_out_; }

private:
    struct File {
        std::string name;              // in the tar
        std::filesystem::path source;  // below the folder
        FileStamp stamp;
        std::int64_t offset = 0;  // of its header in the tar
    };

    void list_files(TarOf of);
    void lay_out();
    const OpenFile& open(const File& file);
    std::size_t read_content(const File& file, std::int64_t offset, std::span<char> buffer);

    std::filesystem::path folder_;
    Links links_;
    bool is_dive_ = true;
    std::vector<File> files_;
    std::vector<std::string> left_out_;
    std::int64_t size_bytes_ = 0;
    const File* open_of_ = nullptr;
    std::unique_ptr<OpenFile> open_;
};

// Hashes an archive that is sent as it is, in one pass.
DiveHashes hash_archive(ByteSource& archive, const BytesDone& bytes_done);

}  // namespace divemesh::api::client
