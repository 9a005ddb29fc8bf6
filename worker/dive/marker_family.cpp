#include "worker/dive/marker_family.hpp"

#include <string>

#include "schemas/enum_text.hpp"
#include "schemas/error.hpp"

namespace divemesh::dive {
namespace {

constexpr EnumText<MarkerFamily> kFamilyTexts[] = {
    {MarkerFamily::Tag36h11, "tag36h11"},
    {MarkerFamily::Tag25h9, "tag25h9"},
    {MarkerFamily::TagStandard41h12, "tagStandard41h12"}};

}  // namespace

std::string_view to_string(MarkerFamily family) { return enum_to_text(kFamilyTexts, family); }

MarkerFamily marker_family_from_string(std::string_view text) {
    const std::string full =
        text.starts_with("tag") ? std::string(text) : "tag" + std::string(text);
    return enum_from_text<MarkerFamily>(kFamilyTexts, full, "marker family");
}

// As defined by the family's authors, so that reading markers.json needs no AprilTag library.
int num_ids(MarkerFamily family) {
    switch (family) {
        case MarkerFamily::Tag36h11: return 587;
        case MarkerFamily::Tag25h9: return 35;
        case MarkerFamily::TagStandard41h12: return 2115;
    }
    throw Error(ErrorCode::InvalidArgument, "unknown marker family");
}

}  // namespace divemesh::dive
