#include "cli/send_dive.hpp"

#include <memory>
#include <optional>

#include "api/client/dive_tar.hpp"
#include "api/client/tus_upload.hpp"
#include "cli/follow.hpp"
#include "cli/progress_bar.hpp"
#include "schemas/error.hpp"
#include "schemas/json.hpp"
#include "worker/dive/archive_identity.hpp"
#include "worker/recording/recorded_kind.hpp"

namespace divemesh::cli {
namespace {

namespace fs = std::filesystem;
namespace client = api::client;

struct HashedSource {
    std::unique_ptr<client::ByteSource> bytes;
    client::DiveHashes hashes;
    std::string filename;
};

HashedSource open_source(const fs::path& dive, ProgressBar& bar) {
    const std::string name = fs::canonical(dive).filename().string();
    // The server tells the contents of other recordings, as it makes the dive of them.
    const bool is_dive = recording::recorded_kind(dive).is_dive();
    if (!fs::is_directory(dive)) {
        auto file = std::make_unique<client::FileSource>(dive);
        auto hashes = client::hash_archive(*file, show_bytes(bar, "hash", file->size_bytes()));
        if (is_dive)
            hashes.content_sha256 = dive::archive_content_sha256(
                dive, [&](const Progress& progress) { bar.show("open", progress.fraction, ""); });
        return {std::move(file), hashes, name};
    }
    auto tar = std::make_unique<client::DiveTar>(
        dive, Links::Follow, is_dive ? client::TarOf::Dive : client::TarOf::Recording);
    if (!tar->left_out().empty())
        bar.say("warning: " + std::to_string(tar->left_out().size()) +
                " special files, or links that lead to no file, are left out; the first is " +
                tar->left_out().front());
    const auto hashes = tar->hash(show_bytes(bar, "hash", tar->size_bytes()));
    return {std::move(tar), hashes, name + ".tar"};
}

// Returns the dive if the server has it already, by its content or by the archive's bytes;
// otherwise nullopt.
std::optional<Dive> find_dive(client::RestClient& rest,
                              const client::DiveHashes& hashes,
                              client::Backoff& backoff) {
    for (const auto& [key, value] : {std::pair{"content_sha256", hashes.content_sha256},
                                     std::pair{"archive_sha256", hashes.archive_sha256}}) {
        if (value.empty()) continue;
        const auto items = backoff.until_done([&rest, &key = key, &value = value] {
            return rest.list("/api/v1/dives", {{key, value}});
        });
        for (const auto& item : items) {
            Dive dive = item.get<Dive>();
            if (dive.state != DiveState::Refused) return dive;
        }
    }
    return std::nullopt;
}

std::chrono::milliseconds milliseconds_of(double seconds) {
    return std::chrono::milliseconds(static_cast<std::int64_t>(seconds * 1000.0));
}

// Returns the id of the server's data, the same under another address; "" of an older server.
std::string id_of_server(client::RestClient& rest, client::Backoff& backoff) {
    try {
        return backoff.until_done([&rest] { return rest.get("/api/v1/info"); })
            .value("data_id", "");
    } catch (const Error& error) {
        if (error.code() != ErrorCode::NotFound && error.code() != ErrorCode::Forbidden) throw;
        return "";
    }
}

// Returns what is remembered of this server. An upload that an earlier version began is remembered
// by the server's address.
client::UploadState state_of(client::RestClient& rest,
                             const HashedSource& source,
                             client::Backoff& backoff) {
    const std::string& archive = source.hashes.archive_sha256;
    const auto folder = client::default_state_folder();
    const client::UploadState by_address(folder, rest.account().server.url(), archive);
    const std::string id = id_of_server(rest, backoff);
    if (id.empty()) return by_address;
    const client::UploadState state(folder, id, archive);
    const client::RememberedUpload begun = by_address.load();
    if (state.load() == client::RememberedUpload{} && begun != client::RememberedUpload{}) {
        state.save(begun);
        by_address.forget();
    }
    return state;
}

std::string send(const client::Account& account,
                 HashedSource& source,
                 const client::UploadState& state,
                 const SendOptions& options,
                 ProgressBar& bar) {
    std::map<std::string, std::string> metadata = {{"filename", source.filename},
                                                   {"sha256", source.hashes.archive_sha256}};
    if (!source.hashes.content_sha256.empty()) metadata["dive"] = source.hashes.content_sha256;
    if (!options.no_job && options.preset.set.empty()) metadata["job"] = options.preset.preset;
    client::TusObserver observer;
    observer.on_progress = show_bytes(bar, "upload", source.bytes->size_bytes());
    observer.on_resumed = [&](std::int64_t offset) {
        bar.say("resuming after " + std::to_string(offset) + " bytes that the server has");
    };
    observer.on_wait = say_waiting(bar);
    client::TusSettings settings;
    settings.max_bytes_per_s = options.limit_rate_bytes_per_s;
    settings.give_up_after = account.give_up_after;
    settings.stall = milliseconds_of(options.stall_timeout_s);
    settings.num_parts = options.parallel;
    const auto upload_path =
        client::upload_by_tus(account, *source.bytes, metadata, state, observer, settings);
    return upload_path.substr(upload_path.rfind('/') + 1);
}

Dive make_dive(client::RestClient& rest,
               const std::string& upload_id,
               std::int64_t archive_bytes,
               client::Backoff& backoff) {
    return rest
        .post_once("/api/v1/dives",
                   {{"upload_id", upload_id}},
                   backoff,
                   client::hashing_timeout(archive_bytes))
        .get<Dive>();
}

// Returns whether the server has the local dive and keeps it: the same bytes, or the same recording
// in another archive, which it has opened and hashed file by file.
bool is_verified(const Dive& dive, const client::DiveHashes& hashes) {
    if (dive.state == DiveState::Refused || dive.deleted_at_ms > 0) return false;
    if (dive.archive_sha256 == hashes.archive_sha256) return true;
    return dive.state == DiveState::Ready && !hashes.content_sha256.empty() &&
           dive.content_sha256 == hashes.content_sha256;
}

// Sends the dive. A remembered upload may belong to a deleted dive, or be unknown to the server:
// then everything is sent again, once.
Dive send_and_make(client::RestClient& rest,
                   HashedSource& source,
                   const SendOptions& options,
                   client::Backoff& backoff,
                   ProgressBar& bar) {
    const client::UploadState state = state_of(rest, source, backoff);
    for (bool again = false;; again = true) {
        const auto upload_id = send(rest.account(), source, state, options, bar);
        backoff.moved();
        try {
            Dive dive = make_dive(rest, upload_id, source.bytes->size_bytes(), backoff);
            state.forget();
            return dive;
        } catch (const Error& error) {
            if (again || error.code() != ErrorCode::NotFound) throw;
            bar.say(std::string("sending it again from the start: ") + error.what());
        }
        state.forget();
    }
}

// Returns the requested reconstruction: an existing one, otherwise a new one.
Job ensure_job(client::RestClient& rest,
               const Dive& dive,
               const PresetOptions& preset,
               client::Backoff& backoff) {
    const auto overrides = overrides_of(preset.set);
    const auto jobs = backoff.until_done([&] {
        return rest.list("/api/v1/jobs", {{"dive_id", dive.id}, {"kind", "reconstruct"}});
    });
    for (const auto& item : jobs) {
        Job job = item.get<Job>();
        const bool usable = !is_finished(job.state) || job.state == JobState::Succeeded;
        if (usable && job.preset == preset.preset && job.options == overrides) return job;
    }
    return rest
        .post_once(client::dive_path(dive.id) + "/jobs",
                   {{"kind", "reconstruct"}, {"preset", preset.preset}, {"options", overrides}},
                   backoff)
        .get<Job>();
}

}  // namespace

SentDive send_dive(client::RestClient& rest, const SendOptions& options) {
    ProgressBar bar;
    client::Backoff backoff(rest.account().give_up_after, say_waiting(bar));
    HashedSource source = open_source(options.dive, bar);
    SentDive sent;
    if (auto known = find_dive(rest, source.hashes, backoff)) {
        bar.say("the server already has this dive");
        sent.dive = std::move(*known);
    } else {
        sent.dive = send_and_make(rest, source, options, backoff, bar);
    }
    sent.verified = is_verified(sent.dive, source.hashes);
    bar.say(sent.verified ? "verified: the server has the complete recording"
                          : "not verified yet: keep the recording until the dive is ready");
    if (!options.no_job) sent.job_id = ensure_job(rest, sent.dive, options.preset, backoff).id;
    return sent;
}

}  // namespace divemesh::cli
