#include "cli/data_options.hpp"

#include <system_error>

#include "schemas/error.hpp"
#include "storage/data_folder.hpp"

namespace divemesh::cli {
namespace {

namespace fs = std::filesystem;

// Returns the absolute path of the folder, because child processes run elsewhere. Creates it if it
// may.
fs::path data_folder(const DataOptions& options, const std::string& instead) {
    if (options.data.empty())
        throw Error(ErrorCode::InvalidArgument,
                    "no data folder: give --data DIR or " + instead + " URL");
    std::error_code failure;
    if (!options.existing_only)
        storage::create_data_folder(options.data, failure);
    else if (!fs::is_directory(options.data))
        throw Error(ErrorCode::NotFound,
                    "there is no data folder " + fs::absolute(options.data).string() +
                        ": give the --data of the server, mount its disk, or start the server "
                        "first, which creates it");
    if (failure)
        throw Error(ErrorCode::Unavailable,
                    "cannot create the data folder " + fs::absolute(options.data).string() + ": " +
                        failure.message() + ": choose another --data folder or change its rights");
    return fs::canonical(options.data);
}

}  // namespace

void add_data_options(CLI::App& command, DataOptions& options) {
    command.add_option("--data",
                       options.data,
                       options.existing_only
                           ? "data folder of a server; holds catalog and blobs"
                           : "data folder, created if missing; holds catalog and blobs");
    command.add_option("--catalog",
                       options.catalog,
                       "URL of the database: sqlite:///path/catalog.db or "
                       "postgresql://user@host/database");
    command.add_option("--blobs",
                       options.blobs,
                       "URL of archives and artifacts: file:///path, or "
                       "s3://bucket[/prefix]?endpoint=https://host&region=NAME");
}

std::string catalog_url(const DataOptions& options) {
    if (!options.catalog.empty()) return options.catalog;
    return "sqlite://" + (data_folder(options, "--catalog") / "catalog.db").string();
}

std::string blobs_url(const DataOptions& options) {
    if (!options.blobs.empty()) return options.blobs;
    return (data_folder(options, "--blobs") / "blobs").string();
}

namespace {

// Returns a folder beside a directory of blobs, otherwise in the data folder, or below the system's
// temporary folder where none is given.
fs::path beside_blobs(const DataOptions& options, const std::string& name) {
    std::string blobs = blobs_url(options);
    const std::string scheme = "file://";
    if (blobs.starts_with(scheme)) blobs.erase(0, scheme.size());
    if (blobs.find("://") != std::string::npos)
        return options.data.empty() ? fs::temp_directory_path() / ("divemesh-" + name)
                                    : fs::absolute(options.data) / name;
    return fs::absolute(blobs).parent_path() / name;
}

}  // namespace

fs::path work_folder(const DataOptions& options) { return beside_blobs(options, "work"); }

fs::path cache_folder(const DataOptions& options) { return beside_blobs(options, "cache"); }

fs::path stage_folder(const DataOptions& options) { return beside_blobs(options, "staged"); }

}  // namespace divemesh::cli
