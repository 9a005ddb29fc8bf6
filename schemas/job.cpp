#include "schemas/job.hpp"

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

}  // namespace divemesh
