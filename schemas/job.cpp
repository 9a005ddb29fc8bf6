#include "schemas/job.hpp"

#include <algorithm>

#include "schemas/enum_text.hpp"

namespace divemesh {
namespace {

constexpr EnumText<JobKind> kTexts[] = {
    {JobKind::Intake, "intake"},
    {JobKind::Reconstruct, "reconstruct"},
    {JobKind::AccuracyReport, "accuracy_report"},
    {JobKind::Compare, "compare"},
};

}  // namespace

std::string_view to_string(JobKind kind) { return enum_to_text(kTexts, kind); }

JobKind job_kind_from_string(std::string_view text) {
    return enum_from_text<JobKind>(kTexts, text, "job kind");
}

std::string_view usual_remedy(ErrorCode code) {
    switch (code) {  // no default: the compiler lists a code that is missing here
        case ErrorCode::InvalidArgument: return "correct the named option and create the job again";
        case ErrorCode::BadData:
            return "see the findings of the dive, correct the recording and upload it again";
        case ErrorCode::TooLarge: return "split the recording into shorter dives";
        case ErrorCode::Unsupported:
            return "convert the recording and check it with `divemesh validate`";
        case ErrorCode::NotFound:
        case ErrorCode::Gone: return "check that the dive and its blobs still exist";
        case ErrorCode::Conflict: return "retry the job that it waited for, then this one";
        case ErrorCode::Unauthorized:
        case ErrorCode::Forbidden: return "give the worker access rights to its folders";
        case ErrorCode::Locked:
        case ErrorCode::TooMany:
        case ErrorCode::Cancelled: return "put it back into the queue with `divemesh retry`";
        case ErrorCode::OutOfQuota:
            return "delete dives of the project, or results if it lacks bytes, or ask for a larger "
                   "quota";
        case ErrorCode::OutOfSpace:
            return "free space on the disks of the workers' scratch folder and of the blobs";
        case ErrorCode::OutOfMemory:
            return "run it on a worker with more memory, or with a larger voxel_m";
        case ErrorCode::PreconditionFailed:  // these concern requests, not jobs
        case ErrorCode::PreconditionRequired:
        case ErrorCode::Unavailable:
            return "see the logs of its attempts; if it is not tried again automatically, use "
                   "`divemesh retry`";
    }
    return "";
}

std::string_view verdict_of(const Job& job) {
    if (job.verdict) return to_string(*job.verdict);
    if (job.requirements.empty()) return "";
    const auto is_met = [](const RequirementResult& result) { return result.met; };
    return std::all_of(job.requirements.begin(), job.requirements.end(), is_met) ? "passed"
                                                                                 : "failed";
}

}  // namespace divemesh
