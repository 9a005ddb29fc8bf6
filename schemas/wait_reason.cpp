#include "schemas/wait_reason.hpp"

#include "schemas/enum_text.hpp"

namespace divemesh {
namespace {

constexpr EnumText<WaitReason> kWaitReasonTexts[] = {
    {WaitReason::Paused, "paused"},
    {WaitReason::Parent, "parent"},
    {WaitReason::QueuePaused, "queue_paused"},
    {WaitReason::Limit, "limit"},
    {WaitReason::Retry, "retry"},
    {WaitReason::Worker, "worker"},
    {WaitReason::Drain, "drain"},
    {WaitReason::Disk, "disk"},
    {WaitReason::Storage, "storage"},
};

}  // namespace

std::string_view to_string(WaitReason reason) { return enum_to_text(kWaitReasonTexts, reason); }

}  // namespace divemesh
