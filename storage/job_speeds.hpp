#pragma once

#include <map>
#include <soci/soci.h>
#include <string>
#include <utility>

#include "schemas/job.hpp"

// How long jobs take, measured: seconds per frame of the dive, for an intake per byte of its
// archive; by kind and preset, the newest job weighing a quarter.
namespace divemesh::storage {

// From a job that is about to succeed; one that had stages from the cache tells nothing.
void learn_speed(soci::session& session, const Job& job);

using JobSpeeds = std::map<std::pair<std::string, std::string>, double>;  // by kind and preset
JobSpeeds read_speeds(soci::session& session);

}  // namespace divemesh::storage
