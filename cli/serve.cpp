#include <filesystem>
#include <functional>
#include <memory>

#include "cli/command.hpp"
#include "cli/data_options.hpp"
#include "cli/exit_code.hpp"
#include "cli/page.hpp"
#include "schemas/reconstruction_options.hpp"
#include "server/server.hpp"
#include "worker/base/cache_folder.hpp"

namespace divemesh::cli {
namespace {

// Returns what gives up the workers' cache of stages for space on the disk.
std::function<void(std::int64_t)> room_maker(const std::filesystem::path& cache) {
    return [cache](std::int64_t wanted_free_bytes) {
        if (base::reachable_free_bytes(cache) >= wanted_free_bytes)
            base::make_room(cache, wanted_free_bytes);
    };
}

}  // namespace

void add_serve(CLI::App& app, Context& context) {
    struct Options {
        DataOptions data;
        server::ServerConfig config;
        double upload_lifetime_h = 168.0;
        int keep_deleted_days = 30;
        int keep_lost_workers_min = 10;
        int hsts_days = 0;
        bool check_only = false;
    };
    auto* command = app.add_subcommand("serve", "run the server: uploads, dives, jobs, events");
    auto options = std::make_shared<Options>();
    options->config.num_workers = 1;
    // clang-format off
    add_data_options(*command, options->data);
    command->add_option("--listen", options->config.listen, "host:port; port 0: any free port")->capture_default_str();
    command->add_option("--workers", options->config.num_workers, "worker processes to run; 0: none")->capture_default_str()->check(CLI::Range(0, 256));
    command->add_option("--io-threads", options->config.num_io_threads, "threads for connections")->capture_default_str()->check(CLI::Range(1, 256));
    command->add_option("--max-upload", options->config.max_upload_bytes, "max size of an archive (500G)")->transform(CLI::AsSizeValue(true));
    command->add_option("--min-free", options->config.min_free_bytes, "disk space that is never used (10G)")->transform(CLI::AsSizeValue(true));
    command->add_option("--max-project-bytes", options->config.max_project_bytes, "max size of a project's dives, results and uploads together (500G); 0: no limit")->transform(CLI::AsSizeValue(true));
    command->add_option("--max-project-dives", options->config.max_project_dives, "max dives of a project; 0: no limit")->capture_default_str()->check(CLI::NonNegativeNumber);
    command->add_option("--max-open-uploads", options->config.max_open_uploads, "max unfinished uploads of a project; 0: no limit")->capture_default_str()->check(CLI::NonNegativeNumber);
    command->add_option("--max-token-uploads", options->config.max_token_uploads, "max unfinished uploads started with one token; 0: no limit")->capture_default_str()->check(CLI::NonNegativeNumber);
    command->add_option("--upload-lifetime", options->upload_lifetime_h, "hours without a new byte after which an upload is removed")->capture_default_str()->check(CLI::Range(1.0, 8760.0));
    command->add_option("--import", options->config.import_folder, "import the dives of this folder (archives, dive folders), then serve")->check(CLI::ExistingDirectory);
    command->add_option("--import-project", options->config.import_project, "project of the imported dives")->capture_default_str();
    command->add_option("--import-job", options->config.import_preset, "preset to reconstruct the imported dives with; default: only store them")->check(CLI::IsMember(std::vector<std::string>(std::begin(kPresets), std::end(kPresets))));
    command->add_option("--tls-cert", options->config.tls_certificate, "certificate chain in PEM; read again on SIGHUP");
    command->add_option("--tls-key", options->config.tls_key, "private key in PEM");
    command->add_option("--hsts-days", options->hsts_days, "with TLS: days for which browsers use only https for this host (Strict-Transport-Security); 0: not stated")->capture_default_str()->check(CLI::Range(0, 3650));
    command->add_flag("--check-config", options->check_only, "check the options and exit");
    command->add_option("--allow-origin", options->config.allowed_origins, "origin whose pages may use the API: https://lab.example (may be repeated)");
    command->add_option("--frame-ancestors", options->config.frame_ancestors, "origin whose pages may show the viewer, /embed, in a frame: https://museum.example (may be repeated)");
    command->add_option("--webhook-network", options->config.webhook_networks, "private network that webhooks may reach: 10.1.0.0/16 (may be repeated)");
    command->add_option("--max-connections", options->config.max_connections, "max open connections; a quarter of them are kept for clients with a valid token")->capture_default_str()->check(CLI::Range(16, 1'000'000));
    command->add_option("--max-address-connections", options->config.max_address_connections, "max open connections of one address (IPv6: of one /64 network), loopback excepted; 0: no limit")->capture_default_str()->check(CLI::NonNegativeNumber);
    command->add_option("--proxy-network", options->config.many_client_networks, "network without that limit, because many clients come from one address there: 10.1.0.5, 10.1.0.0/16 (may be repeated)");
    command->add_option("--trusted-proxy", options->config.trusted_proxies, "proxy that is believed who its client is (Forwarded, X-Forwarded-For, X-Forwarded-Proto), without that limit too: 127.0.0.1, 10.1.0.0/16 (may be repeated)");
    command->add_option("--public-url", options->config.public_url, "address that clients use, e.g. behind a proxy: https://lab.example/dives");
    command->add_option("--max-rate", options->config.max_requests_per_s, "max requests per second of one token; 0: no limit")->capture_default_str()->check(CLI::NonNegativeNumber);
    command->add_option("--keep-deleted-days", options->keep_deleted_days, "days in which a deleted dive or result can be restored")->capture_default_str()->check(CLI::Range(0, 3650));
    command->add_option("--keep-lost-workers", options->keep_lost_workers_min, "minutes for which a worker that died stays in the list of workers")->capture_default_str()->check(CLI::Range(1, 1440));
    command->add_flag("--no-auth", options->config.no_auth, "allow everything without a token; only on loopback");
    // clang-format on
    command->callback([options, &context] {
        context.command = [options] {
            auto& config = options->config;
            config.data = options->data.data;
            config.keep_deleted = std::chrono::hours(24) * options->keep_deleted_days;
            config.keep_lost_workers = std::chrono::minutes(options->keep_lost_workers_min);
            config.hsts = std::chrono::hours(24) * options->hsts_days;
            if (options->check_only) {
                server::check_config(config);
                return kExitDone;
            }
            config.catalog_url = catalog_url(options->data);
            config.blobs_url = blobs_url(options->data);
            config.page = page();
            config.make_room = room_maker(cache_folder(options->data));
            config.upload_lifetime = std::chrono::milliseconds(
                static_cast<std::int64_t>(options->upload_lifetime_h * 3600000.0));
            server::run_server(config);
            return kExitDone;
        };
    });
}

}  // namespace divemesh::cli
