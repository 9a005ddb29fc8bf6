#pragma once

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <string>
#include <sys/mount.h>

#include "tests/temporary_folder.hpp"

namespace divemesh {

// A disk of its own, in memory. Mounting it needs the rights of root.
class SmallDisk {
public:
    explicit SmallDisk(int size_mib)
        : mounted_(::mount("tmpfs",
                           folder_.path().c_str(),
                           "tmpfs",
                           0,
                           ("size=" + std::to_string(size_mib) + "m").c_str()) == 0) {}
    ~SmallDisk() {
        if (mounted_) ::umount2(folder_.path().c_str(), MNT_DETACH);
    }
    SmallDisk(const SmallDisk&) = delete;
    SmallDisk& operator=(const SmallDisk&) = delete;

    bool mounted() const { return mounted_; }
    std::filesystem::path path() const { return folder_.path(); }
    std::int64_t free_bytes() const {
        return static_cast<std::int64_t>(std::filesystem::space(path()).available);
    }
    // Writes a file of so many MiB.
    void write(const std::filesystem::path& file, int size_mib) const {
        std::filesystem::create_directories(file.parent_path());
        std::ofstream stream(file, std::ios::binary);
        const std::string block(1 << 20, 'x');
        for (int i = 0; i < size_mib; ++i) stream << block;
    }
    // Fills it to the last byte.
    void fill() const {
        std::ofstream filler(path() / "filler", std::ios::binary);
        const std::string page(4096, 'x');
        while (filler.write(page.data(), std::ssize(page)).flush()) {
        }
    }

private:
    TemporaryFolder folder_;
    bool mounted_;
};

}  // namespace divemesh
