#include "schemas/truth_file.hpp"

#include "schemas/enum_text.hpp"

namespace divemesh {
namespace {

constexpr EnumText<TruthKind> kTexts[] = {
    {TruthKind::GroundTruth, "ground_truth"},
    {TruthKind::Reference, "reference"},
    {TruthKind::Measurements, "measurements"},
    {TruthKind::Areas, "areas"},
};

}  // namespace

std::string_view to_string(TruthKind kind) { return enum_to_text(kTexts, kind); }

TruthKind truth_kind_from_string(std::string_view text) {
    return enum_from_text<TruthKind>(kTexts, text, "kind of truth");
}

}  // namespace divemesh
