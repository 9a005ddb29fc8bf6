#pragma once

#include <CLI/App.hpp>
#include <filesystem>
#include <string>

namespace divemesh::cli {

// Where all data is stored: --data DIR, or --catalog and --blobs separately.
struct DataOptions {
    bool existing_only = false;  // the data of another program, which creates them
    std::filesystem::path data;
    std::string catalog;
    std::string blobs;
};

// Adds --data, --catalog and --blobs. Set `existing_only` before.
void add_data_options(CLI::App& command, DataOptions& options);

// Both throw Error{InvalidArgument} if neither --data nor the URL is given, Error{NotFound} if the
// data folder must exist and does not.
std::string catalog_url(const DataOptions& options);  // default sqlite:///DIR/catalog.db
std::string blobs_url(const DataOptions& options);    // default DIR/blobs
// Returns the folder for scratch files of running attempts: beside a directory of blobs, otherwise
// in the data folder, or below the system's temporary folder where none is given.
std::filesystem::path work_folder(const DataOptions& options);
// Returns the folder for cached results of stages: beside the work folder.
std::filesystem::path cache_folder(const DataOptions& options);
// Returns the folder in which what goes to an object store is staged: beside the work folder.
std::filesystem::path stage_folder(const DataOptions& options);

}  // namespace divemesh::cli
