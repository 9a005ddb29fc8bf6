#include "storage/backup.hpp"

#include <iostream>
#include <memory>

#include "cli/command.hpp"
#include "cli/data_options.hpp"
#include "cli/exit_code.hpp"
#include "cli/text.hpp"
#include "schemas/error.hpp"
#include "storage/catalog_url.hpp"
#include "storage/data_id.hpp"

namespace divemesh::cli {
namespace {

struct BackupOptions {
    DataOptions data;
    std::filesystem::path file;
};

void say(const storage::BackupSummary& summary, const Context& context) {
    if (context.json) {
        std::cout << nlohmann::json{{"num_blobs", summary.num_blobs},
                                    {"num_bytes", summary.num_bytes},
                                    {"num_missing", summary.num_missing}}
                         .dump(2)
                  << '\n';
        return;
    }
    std::cerr << "catalog and " << summary.num_blobs << " blobs, "
              << bytes_text(static_cast<double>(summary.num_bytes)) << '\n';
    if (summary.num_missing > 0)
        std::cerr << summary.num_missing
                  << " blobs are missing: they were permanently removed earlier\n";
}

int back_up(const BackupOptions& options, const Context& context) {
    storage::Catalog catalog(catalog_url(options.data), storage::Opening::ExistingOnly);
    const auto blobs =
        storage::open_blob_store(blobs_url(options.data), storage::Opening::ExistingOnly);
    storage::require_same_data(catalog, *blobs);
    say(storage::write_backup(catalog, *blobs, options.file), context);
    return kExitDone;
}

int restore(const BackupOptions& options, const Context& context) {
    std::string catalog = catalog_url(options.data);
    if (storage::is_postgresql_url(catalog))
        throw Error(ErrorCode::Unsupported,
                    "a backup is restored into a catalog in SQLite alone: give --data DIR; one in "
                    "PostgreSQL is restored with pg_restore (docs/operation.md)");
    const std::string scheme = "sqlite://";
    if (catalog.starts_with(scheme)) catalog.erase(0, scheme.size());
    const auto blobs = storage::open_blob_store(
        blobs_url(options.data), storage::Opening::CreateIfMissing, stage_folder(options.data));
    say(storage::read_backup(options.file, catalog, *blobs), context);
    return kExitDone;
}

void add(CLI::App& app,
         Context& context,
         const char* name,
         const char* help,
         bool existing_only,
         int (*run)(const BackupOptions&, const Context&)) {
    auto* command = app.add_subcommand(name, help);
    auto options = std::make_shared<BackupOptions>();
    options->data.existing_only = existing_only;
    add_data_options(*command, options->data);
    command->add_option("file", options->file, "backup file (tar)")->required();
    command->callback([options, &context, run] {
        context.command = [options, &context, run] { return run(*options, context); };
    });
}

}  // namespace

void add_backup(CLI::App& app, Context& context) {
    add(app,
        context,
        "backup",
        "copy catalog and blobs into one file while the server runs",
        true,
        back_up);
}

void add_restore(CLI::App& app, Context& context) {
    add(app, context, "restore", "restore a backup into an empty data folder", false, restore);
}

}  // namespace divemesh::cli
