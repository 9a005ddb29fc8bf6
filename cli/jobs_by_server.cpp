#include "cli/jobs_by_server.hpp"

#include <iostream>

#include "api/client/dive_tar.hpp"
#include "api/client/tus_upload.hpp"
#include "cli/exit_code.hpp"
#include "cli/follow.hpp"
#include "cli/progress_bar.hpp"
#include "schemas/content_hash.hpp"
#include "schemas/json.hpp"

namespace divemesh::cli {
namespace {

namespace fs = std::filesystem;
namespace client = api::client;

// Returns the id of the same bytes of that kind if the dive has them already; otherwise "".
std::string find_truth(client::RestClient& rest,
                       const std::string& dive_id,
                       const std::string& kind,
                       const std::string& sha256) {
    for (const auto& item : rest.list(client::dive_path(dive_id) + "/truth", {})) {
        const TruthFile file = item.get<TruthFile>();
        if (to_string(file.kind) == kind && file.sha256 == sha256) return file.id;
    }
    return "";
}

std::string send_truth(client::RestClient& rest,
                       const std::string& dive_id,
                       const std::string& kind,
                       const fs::path& file) {
    ProgressBar bar;
    client::FileSource source(file);
    const std::string sha256 =
        client::hash_archive(source, show_bytes(bar, "hash", source.size_bytes())).archive_sha256;
    if (auto known = find_truth(rest, dive_id, kind, sha256); !known.empty()) return known;
    client::TusObserver observer;
    observer.on_progress = show_bytes(bar, "upload " + kind, source.size_bytes());
    observer.on_wait = say_waiting(bar);
    client::TusSettings settings;
    settings.give_up_after = rest.account().give_up_after;
    const client::UploadState state(client::default_state_folder(),
                                    rest.account().server.url(),
                                    sha256_hex(sha256 + kind + dive_id));
    const auto path = client::upload_by_tus(rest.account(),
                                            source,
                                            {{"filename", file.filename().string()},
                                             {"sha256", sha256},
                                             {"truth", kind},
                                             {"dive_id", dive_id}},
                                            state,
                                            observer,
                                            settings);
    const auto upload = rest.get(path);
    state.forget();
    return upload.at("truth_id").get<std::string>();
}

bool is_job(const std::string& subject) { return subject.starts_with("job_"); }

// Returns the dive of a reconstruction.
std::string dive_of(client::RestClient& rest, const std::string& subject) {
    if (!is_job(subject)) return subject;
    return rest.get(client::job_path(subject)).get<Job>().dive_id;
}

Job make_job(client::RestClient& rest, const ServerJob& wanted) {
    for (const auto& [option, truth] : wanted.truth)
        if (!fs::is_regular_file(truth.file))
            throw Error(ErrorCode::NotFound,
                        "cannot send " + truth.file.string() + ": there is no such file");
    nlohmann::json options = wanted.options;
    const std::string dive_id = dive_of(rest, wanted.subject);
    if (is_job(wanted.subject)) options["job"] = wanted.subject;
    for (const auto& [option, truth] : wanted.truth)
        options[option] = send_truth(rest, dive_of(rest, truth.subject), truth.kind, truth.file);
    client::Backoff backoff(rest.account().give_up_after, {});
    return rest
        .post_once(client::dive_path(dive_id) + "/jobs",
                   {{"kind", wanted.kind}, {"options", options}},
                   backoff)
        .get<Job>();
}

}  // namespace

bool is_on_server(const CLI::App& command, const fs::path& subject) {
    return command.get_option("--server")->count() > 0 && !fs::is_directory(subject);
}

int run_on_server(client::RestClient& rest,
                  const ServerJob& wanted,
                  const Context& context,
                  const std::function<int(const std::string& artifacts)>& done) {
    const Job job = make_job(rest, wanted);
    if (!wanted.wait) {
        std::cout << (context.json ? nlohmann::json{{"job", job.id}}.dump(2) : "job " + job.id)
                  << '\n';
        return kExitDone;
    }
    const Job finished = wait_for_job(rest, job.id);
    if (finished.state != JobState::Succeeded) {
        print_failure(rest, finished);
        return kExitFailed;
    }
    if (!wanted.out.empty()) download_job(rest, job.id, {}, wanted.out);
    return done(client::job_path(job.id) + "/artifacts/");
}

}  // namespace divemesh::cli
