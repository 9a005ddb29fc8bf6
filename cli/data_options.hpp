#pragma once

#include <CLI/App.hpp>
#include <filesystem>
#include <string>

namespace divemesh::cli {

// Where everything is kept: --data DIR, or --catalog and --blobs apart.
struct DataOptions {
    std::filesystem::path data;
    std::string catalog;
    std::string blobs;
};

void add_data_options(CLI::App& command, DataOptions& options);

// Both throw Error{InvalidArgument} when neither --data nor the URL is given.
std::string catalog_url(const DataOptions& options);  // default sqlite:///DIR/catalog.db
std::string blobs_url(const DataOptions& options);    // default DIR/blobs
// Scratch of running attempts: beside a directory of blobs, else below the system's temporary
// folder.
std::filesystem::path work_folder(const DataOptions& options);
// What stages made, kept for other attempts: beside the work folder.
std::filesystem::path cache_folder(const DataOptions& options);

}  // namespace divemesh::cli
