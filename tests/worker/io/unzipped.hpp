#pragma once

#include <gtest/gtest.h>

#include <archive.h>
#include <archive_entry.h>
#include <filesystem>
#include <map>
#include <string>

namespace divemesh::io {

// Returns the files of a zip by their names.
inline std::map<std::string, std::string> unzipped(const std::filesystem::path& file) {
    std::map<std::string, std::string> files;
    archive* zip = archive_read_new();
    archive_read_support_format_zip(zip);
    EXPECT_EQ(archive_read_open_filename(zip, file.c_str(), 1 << 16), ARCHIVE_OK);
    for (archive_entry* entry = nullptr; archive_read_next_header(zip, &entry) == ARCHIVE_OK;) {
        std::string& text = files[archive_entry_pathname(entry)];
        char segment[4096];
        for (la_ssize_t n = 0; (n = archive_read_data(zip, segment, sizeof segment)) > 0;)
            text.append(segment, static_cast<std::size_t>(n));
    }
    archive_read_free(zip);
    return files;
}

}  // namespace divemesh::io
