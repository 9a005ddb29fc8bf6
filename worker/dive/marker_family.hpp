#pragma once

#include <string_view>

namespace divemesh::dive {

// The AprilTag families that can be detected (Olson, "AprilTag", ICRA 2011; Krogius, Haggenmiller
// and Olson, "Flexible layouts for fiducial tags", IROS 2019), named like their image files.
enum class MarkerFamily { Tag36h11, Tag25h9, TagStandard41h12 };

std::string_view to_string(MarkerFamily family);  // tag36h11, tag25h9, tagStandard41h12
// Accepts names without "tag" too. Throws Error{InvalidArgument} that lists the families.
MarkerFamily marker_family_from_string(std::string_view text);

int num_ids(MarkerFamily family);  // ids are 0 to num_ids - 1

}  // namespace divemesh::dive
