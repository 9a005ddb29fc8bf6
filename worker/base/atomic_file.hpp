#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>

#include "schemas/file_descriptor.hpp"

namespace divemesh::base {

// Whether commit() syncs the file to disk, so that it survives a power cut. For many small files
// that are easy to make again, syncing each would take longer than making them.
enum class Durability { Synced, Unsynced };

// A file that appears under its name complete or not at all: it is written as `name.partial`,
// synced and renamed, and the folder is synced. Throws Error{OutOfSpace} when the disk or a quota
// is full, Error{Unavailable} with the system's reason otherwise.
class AtomicFile {
public:
    explicit AtomicFile(std::filesystem::path file, Durability durability = Durability::Synced);
    ~AtomicFile();  // without commit() the partial file is deleted
    AtomicFile(const AtomicFile&) = delete;
    AtomicFile& operator=(const AtomicFile&) = delete;

    void write(std::string_view bytes);
    // Replaces bytes that were written before; write() continues at the end.
    void overwrite(std::uint64_t offset_bytes, std::string_view bytes);
    void commit();

private:
    void flush();
    // Calls `write_some` until all bytes are written.
    template <typename Write>
    void write_all(std::string_view rest, const Write& write_some);

    std::filesystem::path file_;
    std::filesystem::path partial_;
    Durability durability_;
    FileDescriptor opened_;
    std::string buffer_;
};

// Writes a whole file with AtomicFile; throws as it does.
void write_file(const std::filesystem::path& file,
                std::string_view bytes,
                Durability durability = Durability::Synced);

}  // namespace divemesh::base
