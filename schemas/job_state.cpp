#include "schemas/job_state.hpp"

#include "schemas/enum_text.hpp"

namespace divemesh {
namespace {

constexpr EnumText<JobState> kJobStateTexts[] = {
    {JobState::Held, "held"},
    {JobState::Queued, "queued"},
    {JobState::Running, "running"},
    {JobState::Succeeded, "succeeded"},
    {JobState::Failed, "failed"},
    {JobState::Dead, "dead"},
    {JobState::Cancelled, "cancelled"},
};

constexpr EnumText<AttemptState> kAttemptStateTexts[] = {
    {AttemptState::Running, "running"},
    {AttemptState::Succeeded, "succeeded"},
    {AttemptState::Failed, "failed"},
    {AttemptState::Cancelled, "cancelled"},
    {AttemptState::LeaseLost, "lease_lost"},
    {AttemptState::Released, "released"},
};

}  // namespace

std::string_view to_string(JobState state) { return enum_to_text(kJobStateTexts, state); }

JobState job_state_from_string(std::string_view text) {
    return enum_from_text<JobState>(kJobStateTexts, text, "job state");
}

std::string_view to_string(AttemptState state) { return enum_to_text(kAttemptStateTexts, state); }

AttemptState attempt_state_from_string(std::string_view text) {
    return enum_from_text<AttemptState>(kAttemptStateTexts, text, "attempt state");
}

}  // namespace divemesh
