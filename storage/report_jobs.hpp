#pragma once

#include <soci/soci.h>
#include <vector>

#include "schemas/dive.hpp"
#include "schemas/truth_file.hpp"
#include "storage/job_store.hpp"

namespace divemesh::storage {

inline constexpr const char* kLaterAreas = "later_areas";

// Looks up the jobs and files that a report or a comparison names, and writes their ids into its
// options, so that these record what it was made of. Leaves other kinds of jobs unchanged. It reads
// these options:
//
//   job      the reconstruction of this dive; without it the newest that has succeeded, otherwise
//            the newest under way, otherwise a new one by the preset, which then runs first
//   with     of a comparison: a reconstruction, or a dive whose reconstruction is found as above
//   ground_truth, reference, measurements, areas
//            of a report: id or name of a file of truth of this dive; without it the newest of that
//            kind that no report has found unreadable (then `newest`, a list, holds the kind), and
//            kTruthOfDive for the truth in the recording itself
//   areas    of a comparison: id or name of such a file of this dive; without it no areas
//   later_areas
//            of a comparison that has areas: the same for the dive that it is compared with
//   tag      of a report: a tag of the dive, whose earlier metrics it is compared with
//
// Throws Error{NotFound} for an object that the project lacks, Error{InvalidArgument} for one of
// another kind or another dive, Error{Gone} for a reconstruction whose result was deleted.
void resolve_names(soci::session& session, const Dive& dive, NewJob& request);

// Marks the file that a report could not read. Returns true if it was not chosen by name: the job's
// options then name the next file, if any, and the report can be retried.
bool set_truth_aside(soci::session& session, const Job& job, const UnreadableTruth& unreadable);

// Returns the files that are newer than those a report is made of, but unreadable.
std::vector<TruthFile> truth_set_aside(soci::session& session, const Job& job);

}  // namespace divemesh::storage
