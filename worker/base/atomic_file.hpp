#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <string_view>

#include "schemas/file_descriptor.hpp"

namespace divemesh::base {

// Whether a file outlives a power cut from commit() on. For many small ones that are made again
// with ease, a sync of each would take longer than making them.
enum class Durability { Synced, Unsynced };

// A file that appears under its name whole or not at all: written beside it as `name.partial`,
// synced, renamed, the folder synced. Throws Error{OutOfSpace} when the disk or a quota is full,
// Error{Unavailable} with the system's reason otherwise.
class AtomicFile {
public:
    explicit AtomicFile(std::filesystem::path file, Durability durability = Durability::Synced);
    ~AtomicFile();  // without commit() nothing is left behind
    AtomicFile(const AtomicFile&) = delete;
    AtomicFile& operator=(const AtomicFile&) = delete;

    void write(std::string_view bytes);
    void commit();

private:
    void flush();

    std::filesystem::path file_;
    std::filesystem::path partial_;
    Durability durability_;
    FileDescriptor opened_;
    std::string buffer_;
};

void write_file(const std::filesystem::path& file,
                std::string_view bytes,
                Durability durability = Durability::Synced);

}  // namespace divemesh::base
