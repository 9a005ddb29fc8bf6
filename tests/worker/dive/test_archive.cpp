#include "tests/worker/dive/test_archive.hpp"

#include <algorithm>
#include <fstream>
#include <iterator>
#include <stdexcept>
#include <vector>

namespace divemesh::dive {
namespace {

using EntryOwner = std::unique_ptr<archive_entry, void (*)(archive_entry*)>;

EntryOwner new_entry(const std::string& name, unsigned int type) {
    EntryOwner entry(archive_entry_new(), &archive_entry_free);
    archive_entry_set_pathname(entry.get(), name.c_str());
    archive_entry_set_filetype(entry.get(), type);
    archive_entry_set_perm(entry.get(), 0644);
    archive_entry_set_size(entry.get(), 0);
    return entry;
}

}  // namespace

TestArchive::TestArchive(const std::filesystem::path& file,
                         Container container,
                         const std::string& passphrase)
    : writer_(archive_write_new(), &archive_write_free) {
    if (container == Container::Zip)
        archive_write_set_format_zip(writer_.get());
    else
        archive_write_set_format_pax_restricted(writer_.get());
    if (container == Container::TarGz) archive_write_add_filter_gzip(writer_.get());
    if (container == Container::TarZst) archive_write_add_filter_zstd(writer_.get());
    if (!passphrase.empty()) {
        archive_write_set_options(writer_.get(), "zip:encryption=traditional");
        archive_write_set_passphrase(writer_.get(), passphrase.c_str());
    }
    if (archive_write_open_filename(writer_.get(), file.c_str()) != ARCHIVE_OK)
        throw std::runtime_error(archive_error_string(writer_.get()));
}

TestArchive::~TestArchive() { archive_write_close(writer_.get()); }

void TestArchive::write(archive_entry* entry, const std::string& bytes) {
    if (archive_write_header(writer_.get(), entry) < ARCHIVE_WARN)
        throw std::runtime_error(archive_error_string(writer_.get()));
    if (!bytes.empty()) archive_write_data(writer_.get(), bytes.data(), bytes.size());
}

void TestArchive::add(const std::string& name, const std::string& bytes) {
    const auto entry = new_entry(name, AE_IFREG);
    archive_entry_set_size(entry.get(), static_cast<la_int64_t>(bytes.size()));
    write(entry.get(), bytes);
}

void TestArchive::add_special(const std::string& name,
                              unsigned int type,
                              const std::string& target) {
    const auto entry = new_entry(name, type);
    if (!target.empty()) archive_entry_set_symlink(entry.get(), target.c_str());
    write(entry.get(), "");
}

void TestArchive::add_hard_link(const std::string& name, const std::string& target) {
    const auto entry = new_entry(name, AE_IFREG);
    archive_entry_set_hardlink(entry.get(), target.c_str());
    write(entry.get(), "");
}

void TestArchive::add_folder(const std::filesystem::path& folder, const std::string& prefix) {
    std::vector<std::filesystem::path> files;
    for (const auto& item : std::filesystem::recursive_directory_iterator(folder))
        if (item.is_regular_file()) files.push_back(item.path());
    std::sort(files.begin(), files.end());
    for (const auto& file : files) {
        std::ifstream stream(file, std::ios::binary);
        add(prefix + std::filesystem::relative(file, folder).string(),
            {std::istreambuf_iterator<char>(stream), {}});
    }
}

}  // namespace divemesh::dive
