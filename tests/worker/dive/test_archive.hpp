#pragma once

#include <archive.h>
#include <archive_entry.h>
#include <filesystem>
#include <memory>
#include <string>

namespace divemesh::dive {

enum class Container { Zip, Tar, TarGz, TarZst };

// Writes an archive entry by entry, including hostile entries.
class TestArchive {
public:
    // Encrypts a zip if there is a passphrase.
    TestArchive(const std::filesystem::path& file,
                Container container,
                const std::string& passphrase = "");
    ~TestArchive();
    TestArchive(const TestArchive&) = delete;
    TestArchive& operator=(const TestArchive&) = delete;

    void add(const std::string& name, const std::string& bytes);
    // Adds an entry that is not a plain file: AE_IFLNK, AE_IFCHR, AE_IFIFO ...
    void add_special(const std::string& name, unsigned int type, const std::string& target = "");
    void add_hard_link(const std::string& name, const std::string& target);
    // Adds every regular file below `folder`, under `prefix`.
    void add_folder(const std::filesystem::path& folder, const std::string& prefix = "");

private:
    void write(archive_entry* entry, const std::string& bytes);

    std::unique_ptr<::archive, int (*)(::archive*)> writer_;
};

}  // namespace divemesh::dive
