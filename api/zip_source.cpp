#include "api/zip_source.hpp"

#include <algorithm>
#include <archive.h>
#include <archive_entry.h>
#include <array>

#include "schemas/error.hpp"

namespace divemesh::api {
namespace {

constexpr std::size_t kReadBytes = std::size_t{128} << 10;

bool is_compressed(const std::string& name) {
    constexpr std::array<const char*, 5> kEndings = {".jpg", ".png", ".glb", ".tif", ".zip"};
    return std::any_of(kEndings.begin(), kEndings.end(), [&](const char* ending) {
        return name.ends_with(ending);
    });
}

class ZipSource : public BodySource {
public:
    ZipSource(storage::BlobStore& blobs, std::vector<ZippedFile> files, std::int64_t time_s)
        : blobs_(blobs), files_(std::move(files)), time_s_(time_s) {
        check(archive_write_set_format_zip(zip_.get()));
        check(archive_write_set_options(zip_.get(), "zip:compression-level=1"));
        check(archive_write_set_bytes_per_block(zip_.get(), 0));
        check(archive_write_open(zip_.get(), this, nullptr, keep, nullptr));
    }

    std::size_t read(std::span<char> bytes) override {
        while (num_taken_ == made_.size() && !is_closed_) make_more();
        const std::size_t size = std::min(bytes.size(), made_.size() - num_taken_);
        std::copy_n(made_.begin() + static_cast<std::ptrdiff_t>(num_taken_), size, bytes.begin());
        num_taken_ += size;
        return size;
    }

private:
    struct Free {
        void operator()(archive* zip) const { archive_write_free(zip); }
        void operator()(archive_entry* entry) const { archive_entry_free(entry); }
    };

    static la_ssize_t keep(archive*, void* self, const void* bytes, std::size_t size) {
        const char* first = static_cast<const char*>(bytes);
        auto& made = static_cast<ZipSource*>(self)->made_;
        made.insert(made.end(), first, first + size);
        return static_cast<la_ssize_t>(size);
    }

    void check(la_ssize_t result) {
        if (result >= ARCHIVE_WARN) return;
        const char* what = archive_error_string(zip_.get());
        throw Error(ErrorCode::Unavailable,
                    std::string("the archive cannot be made: ") + (what == nullptr ? "" : what));
    }

    // Makes the next part of the archive, which may have no bytes.
    void make_more() {
        made_.clear();
        num_taken_ = 0;
        if (num_left_ > 0) {
            add_bytes();
        } else if (next_ < files_.size()) {
            begin(files_[next_]);
            ++next_;
        } else {
            check(archive_write_close(zip_.get()));
            is_closed_ = true;
        }
    }

    void begin(const ZippedFile& file) {
        reader_ = blobs_.open(file.blob);
        if (reader_->size_bytes() != file.size_bytes)
            throw Error(ErrorCode::BadData, file.name + " is not as long as it was");
        num_left_ = file.size_bytes;
        const std::unique_ptr<archive_entry, Free> entry(archive_entry_new());
        archive_entry_set_pathname_utf8(entry.get(), file.name.c_str());
        archive_entry_set_size(entry.get(), file.size_bytes);
        archive_entry_set_filetype(entry.get(), AE_IFREG);
        archive_entry_set_perm(entry.get(), 0644);
        archive_entry_set_mtime(entry.get(), time_s_, 0);
        check(is_compressed(file.name) ? archive_write_zip_set_compression_store(zip_.get())
                                       : archive_write_zip_set_compression_deflate(zip_.get()));
        check(archive_write_header(zip_.get(), entry.get()));
    }

    void add_bytes() {
        buffer_.resize(kReadBytes);
        const std::int64_t offset = reader_->size_bytes() - num_left_;
        const std::size_t size = reader_->read_at(offset, buffer_);
        if (size == 0) throw Error(ErrorCode::BadData, "a file of the archive ends too early");
        check(archive_write_data(zip_.get(), buffer_.data(), size));
        num_left_ -= static_cast<std::int64_t>(size);
    }

    storage::BlobStore& blobs_;
    std::vector<ZippedFile> files_;
    std::int64_t time_s_;
    std::size_t next_ = 0;
    std::shared_ptr<storage::BlobReader> reader_;  // of the file before `next_`
    std::int64_t num_left_ = 0;                    // of its bytes
    bool is_closed_ = false;
    std::vector<char> buffer_;
    std::vector<char> made_;
    std::size_t num_taken_ = 0;                                // of made_
    std::unique_ptr<archive, Free> zip_{archive_write_new()};  // last: its end may write to made_
};

}  // namespace

std::unique_ptr<BodySource> zip_source(storage::BlobStore& blobs,
                                       std::vector<ZippedFile> files,
                                       std::int64_t time_s) {
    return std::make_unique<ZipSource>(blobs, std::move(files), time_s);
}

}  // namespace divemesh::api
