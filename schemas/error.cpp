#include "schemas/error.hpp"

#include "schemas/enum_text.hpp"

namespace divemesh {
namespace {

constexpr EnumText<ErrorCode> kTexts[] = {
    {ErrorCode::InvalidArgument, "invalid_argument"},
    {ErrorCode::BadData, "bad_data"},
    {ErrorCode::NotFound, "not_found"},
    {ErrorCode::Gone, "gone"},
    {ErrorCode::Conflict, "conflict"},
    {ErrorCode::Locked, "locked"},
    {ErrorCode::PreconditionFailed, "precondition_failed"},
    {ErrorCode::PreconditionRequired, "precondition_required"},
    {ErrorCode::TooLarge, "too_large"},
    {ErrorCode::TooMany, "too_many"},
    {ErrorCode::Unauthorized, "unauthorized"},
    {ErrorCode::Forbidden, "forbidden"},
    {ErrorCode::Unsupported, "unsupported"},
    {ErrorCode::Cancelled, "cancelled"},
    {ErrorCode::OutOfQuota, "out_of_quota"},
    {ErrorCode::OutOfSpace, "out_of_space"},
    {ErrorCode::OutOfMemory, "out_of_memory"},
    {ErrorCode::Unavailable, "unavailable"},
};

}  // namespace

std::string_view to_string(ErrorCode code) { return enum_to_text(kTexts, code); }

ErrorCode error_code_from_string(std::string_view text) {
    return enum_from_text<ErrorCode>(kTexts, text, "error code");
}

}  // namespace divemesh
