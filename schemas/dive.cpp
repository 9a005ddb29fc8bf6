#include "schemas/dive.hpp"

#include "schemas/enum_text.hpp"

namespace divemesh {
namespace {

constexpr EnumText<DiveState> kTexts[] = {
    {DiveState::Checking, "checking"},
    {DiveState::Ready, "ready"},
    {DiveState::Refused, "refused"},
};

}  // namespace

std::string_view to_string(DiveState state) { return enum_to_text(kTexts, state); }

DiveState dive_state_from_string(std::string_view text) {
    return enum_from_text<DiveState>(kTexts, text, "dive state");
}

}  // namespace divemesh
