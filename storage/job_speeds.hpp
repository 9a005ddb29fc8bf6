#pragma once

#include <map>
#include <soci/soci.h>
#include <string>
#include <utility>

#include "schemas/job.hpp"

// Measured durations of jobs: seconds per frame of the dive, for an intake per byte of its archive;
// by kind and preset. The newest job has a weight of a quarter.
namespace divemesh::storage {

// Learns from a job that is about to succeed; ignores one with stages from the cache.
void learn_speed(soci::session& session, const Job& job);

using JobSpeeds = std::map<std::pair<std::string, std::string>, double>;  // by kind and preset
JobSpeeds read_speeds(soci::session& session);

}  // namespace divemesh::storage
