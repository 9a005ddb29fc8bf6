#include "storage/report_jobs.hpp"

#include <algorithm>

#include "schemas/error.hpp"
#include "schemas/json.hpp"
#include "storage/dive_rows.hpp"
#include "storage/job_changes.hpp"
#include "storage/job_rows.hpp"
#include "storage/result_removal.hpp"
#include "storage/sql.hpp"
#include "storage/truth_store.hpp"

namespace divemesh::storage {
namespace {

constexpr const char* kNewest = "newest";

std::string text_option(const NewJob& request, const std::string& name) {
    const auto option = request.options.find(name);
    if (option == request.options.end()) return "";
    if (!option->is_string())
        throw Error(ErrorCode::InvalidArgument, "option \"" + name + "\" must be a text");
    return option->get<std::string>();
}

std::optional<Job> newest(soci::session& session,
                          const Dive& dive,
                          const std::string& states,
                          const std::string& version) {
    return select_one<JobRow>(session,
                              "SELECT " + std::string(kJobColumns) +
                                  " FROM jobs WHERE dive_id = :dive AND kind = 'reconstruct'"
                                  " AND deleted_at_ms = 0"
                                  " AND state IN (" +
                                  states +
                                  ") AND (:version = '' OR id IN (SELECT job_id FROM metric_sets"
                                  "   WHERE metric_sets.dive_id = :dive AND version = :version))"
                                  " ORDER BY created_at_ms DESC, id DESC LIMIT 1",
                              soci::use(dive.id, "dive"),
                              soci::use(version, "version"));
}

Job reconstruction_of(soci::session& session, const Dive& dive, const NewJob& request) {
    require_usable(dive);
    if (auto done = newest(session, dive, "'succeeded'", request.fresh_version)) return *done;
    if (auto under_way = newest(session, dive, "'held', 'queued', 'running'", ""))
        return *under_way;
    return insert_job(session,
                      {.project = dive.project,
                       .dive_id = dive.id,
                       .preset = request.preset,
                       .priority = request.priority});
}

Job named_reconstruction(soci::session& session, const Dive& dive, const std::string& id) {
    Job job = read_job(session, id);
    if (job.project != dive.project) throw Error(ErrorCode::NotFound, "no job " + id);
    if (job.kind != JobKind::Reconstruct)
        throw Error(ErrorCode::InvalidArgument,
                    "job " + id + " is not a reconstruction: give one that is");
    require_result(session, id);
    return job;
}

std::optional<Dive> find_dive(soci::session& session, const std::string& id) {
    return select_one<DiveRow>(session,
                               "SELECT " + std::string(kDiveColumns) + " FROM dives WHERE id = :id",
                               soci::use(id, "id"));
}

// Returns another reconstruction of the same dive, or the reconstruction of another dive.
Job other_reconstruction(soci::session& session, const Dive& dive, const NewJob& request) {
    const std::string with = text_option(request, "with");
    if (with.empty())
        throw Error(ErrorCode::InvalidArgument,
                    "option \"with\" is missing: give the dive or job to compare with");
    const auto other = find_dive(session, with);
    if (!other) return named_reconstruction(session, dive, with);
    if (other->project != dive.project) throw Error(ErrorCode::NotFound, "no dive " + with);
    return reconstruction_of(session, *other, request);
}

// Returns the file with an id, or the newest with that name; without either the newest readable
// one.
std::string truth_id(const std::vector<TruthFile>& files,
                     TruthKind kind,
                     const std::string& wanted) {
    for (auto file = files.rbegin(); file != files.rend(); ++file)
        if (file->kind == kind &&
            (wanted.empty() ? file->problem.empty() : file->id == wanted || file->name == wanted))
            return file->id;
    if (wanted.empty()) return "";
    throw Error(
        ErrorCode::NotFound,
        "the dive has no " + std::string(to_string(kind)) + " \"" + wanted + "\": upload it first");
}

void resolve_truth(soci::session& session, const Dive& dive, NewJob& request) {
    const auto files = truth_of_dive(session, dive.id);
    nlohmann::json newest = nlohmann::json::array();
    for (const TruthKind kind : kTruthKinds) {
        const std::string name(to_string(kind));
        const std::string wanted = text_option(request, name);
        if (wanted == kTruthOfDive) continue;
        const std::string id = truth_id(files, kind, wanted);
        request.options.erase(name);
        if (!id.empty()) request.options[name] = id;
        if (wanted.empty() && !id.empty()) newest.push_back(name);
    }
    if (!newest.empty()) request.options[kNewest] = newest;
}

// Returns true if the file was not chosen by name but is the newest of its kind.
bool takes_newest(const nlohmann::json& options, const std::string& kind) {
    const auto newest = options.value(kNewest, std::vector<std::string>());
    return !options.contains(kind) || std::find(newest.begin(), newest.end(), kind) != newest.end();
}

// Resolves the areas of a comparison: outlines drawn on one of its dives, if requested.
void resolve_areas(soci::session& session,
                   const std::string& dive_id,
                   const std::string& option,
                   NewJob& request) {
    const std::string wanted = text_option(request, option);
    request.options.erase(option);
    if (!wanted.empty())
        request.options[option] =
            truth_id(truth_of_dive(session, dive_id), TruthKind::Areas, wanted);
}

void check_tag(const Dive& dive, const NewJob& request) {
    const std::string tag = text_option(request, "tag");
    if (!tag.empty() && std::find(dive.tags.begin(), dive.tags.end(), tag) == dive.tags.end())
        throw Error(ErrorCode::InvalidArgument, "dive " + dive.id + " has no tag \"" + tag + "\"");
}

}  // namespace

void resolve_names(soci::session& session, const Dive& dive, NewJob& request) {
    if (request.kind != JobKind::AccuracyReport && request.kind != JobKind::Compare) return;
    if (request.kind == JobKind::AccuracyReport) {
        check_tag(dive, request);
        resolve_truth(session, dive, request);
    }
    const std::string wanted = text_option(request, "job");
    const Job job = wanted.empty() ? reconstruction_of(session, dive, request)
                                   : named_reconstruction(session, dive, wanted);
    if (job.dive_id != dive.id)
        throw Error(ErrorCode::InvalidArgument,
                    "job " + job.id + " belongs to dive " + job.dive_id + ", not to " + dive.id);
    request.options["job"] = job.id;
    request.parents.push_back(job.id);
    if (request.kind == JobKind::Compare) {
        const std::string areas(to_string(TruthKind::Areas));
        if (!text_option(request, kLaterAreas).empty() && text_option(request, areas).empty())
            throw Error(ErrorCode::InvalidArgument,
                        "option \"later_areas\" was given without \"areas\": give those of the "
                        "earlier dive too");
        resolve_areas(session, dive.id, areas, request);
        const Job other = other_reconstruction(session, dive, request);
        resolve_areas(session, other.dive_id, kLaterAreas, request);
        if (other.id == job.id)
            throw Error(ErrorCode::InvalidArgument,
                        "job " + job.id + " would be compared with itself: give another one");
        request.options["with"] = other.id;
        request.parents.push_back(other.id);
    }
    request.preset = job.preset;
}

bool set_truth_aside(soci::session& session, const Job& job, const UnreadableTruth& unreadable) {
    const std::string kind(to_string(unreadable.kind));
    const auto id = job.options.find(kind);
    if (id == job.options.end() || *id == kTruthOfDive) return false;
    mark_unreadable(session, id->get<std::string>(), unreadable.problem);
    if (!takes_newest(job.options, kind)) return false;
    nlohmann::json options = job.options;
    const std::string next = truth_id(truth_of_dive(session, job.dive_id), unreadable.kind, "");
    options.erase(kind);
    if (!next.empty()) options[kind] = next;
    const std::string text = to_text(options);
    execute(session,
            "UPDATE jobs SET options = :options WHERE id = :id",
            soci::use(text, "options"),
            soci::use(job.id, "id"));
    return true;
}

std::vector<TruthFile> truth_set_aside(soci::session& session, const Job& job) {
    std::vector<TruthFile> aside;
    const auto files = truth_of_dive(session, job.dive_id);
    for (const TruthKind kind : kTruthKinds) {
        const std::string name(to_string(kind));
        if (!takes_newest(job.options, name)) continue;
        const std::string used = job.options.value(name, "");
        for (auto file = files.rbegin(); file != files.rend() && file->id != used; ++file)
            if (file->kind == kind && !file->problem.empty()) aside.push_back(*file);
    }
    return aside;
}

}  // namespace divemesh::storage
