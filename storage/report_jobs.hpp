#pragma once

#include <soci/soci.h>
#include <vector>

#include "schemas/dive.hpp"
#include "schemas/truth_file.hpp"
#include "storage/job_store.hpp"

namespace divemesh::storage {

inline constexpr const char* kLaterAreas = "later_areas";

// Looks up what a report or a comparison names and writes the ids into its options, so that they
// say for ever what it was made of; other kinds are left as they are. The options that are read:
//
//   job      the reconstruction of this dive; without it the newest that has succeeded, else the
//            newest under way, else a new one by the preset, which then is the first to be done
//   with     of a comparison: a reconstruction, or a dive whose is found in the same way
//   ground_truth, reference, measurements, areas
//            of a report: id or name of a file of truth of this dive; without it the newest of that
//            kind that no report has found unreadable (then `newest`, a list, holds the kind), and
//            kTruthOfDive for what the recording itself brings
//   areas    of a comparison: id or name of such a file of this dive; without it none
//   later_areas
//            of a comparison that has areas: the same of the dive that it is compared with
//   tag      of a report: one of the dive's, whose earlier figures it is held against
//
// Throws Error{NotFound} for what the project does not have, Error{InvalidArgument} for what has
// another kind or belongs to another dive.
void resolve_names(soci::session& session, const Dive& dive, NewJob& request);

// Marks the file that a report could not read. True: it was not asked for by name, and the job's
// options now say which one comes next, if any: the report can be tried again.
bool set_truth_aside(soci::session& session, const Job& job, const UnreadableTruth& unreadable);

// The files that are newer than what a report is made of, but unreadable.
std::vector<TruthFile> truth_set_aside(soci::session& session, const Job& job);

}  // namespace divemesh::storage
