#pragma once

#include <archive.h>
#include <archive_entry.h>
#include <exception>
#include <filesystem>
#include <memory>
#include <string>
#include <string_view>

#include "worker/base/atomic_file.hpp"

namespace divemesh::io {

// A zip that is written entry by entry, each in parts. The same entries give the same bytes. Throws
// as AtomicFile does.
class ZipWriter {
public:
    explicit ZipWriter(const std::filesystem::path& file);

    void begin(const std::string& name);
    void write(std::string_view bytes);  // of the entry that began last
    void commit();                       // the file does not exist before

private:
    struct Free {
        void operator()(archive* zip) const { archive_write_free(zip); }
        void operator()(archive_entry* entry) const { archive_entry_free(entry); }
    };

    static la_ssize_t write_to_file(archive*, void* self, const void* bytes, std::size_t size);
    void check(int result);

    base::AtomicFile output_;
    std::exception_ptr error_;  // of the file; it is passed on unchanged through the library
    std::unique_ptr<archive, Free> archive_;
};

}  // namespace divemesh::io
