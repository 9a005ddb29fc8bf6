#include "worker/markers/tag_layout.hpp"

#include <apriltag/common/image_u8.h>
#include <apriltag/tag25h9.h>
#include <apriltag/tag36h11.h>
#include <apriltag/tagStandard41h12.h>
#include <memory>
#include <string>

#include "schemas/error.hpp"
#include "worker/markers/april_tag.hpp"

namespace divemesh::markers {

AprilTagFamily make_april_tag_family(dive::MarkerFamily family) {
    switch (family) {
        case dive::MarkerFamily::Tag36h11: return {tag36h11_create(), tag36h11_destroy};
        case dive::MarkerFamily::Tag25h9: return {tag25h9_create(), tag25h9_destroy};
        case dive::MarkerFamily::TagStandard41h12:
            return {tagStandard41h12_create(), tagStandard41h12_destroy};
    }
    throw Error(ErrorCode::InvalidArgument, "unknown marker family");
}

TagLayout tag_layout(dive::MarkerFamily family) {
    const AprilTagFamily tags = make_april_tag_family(family);
    return {.total_cells = tags->total_width,
            .size_cells = tags->width_at_border,
            .white_within = tags->reversed_border};
}

cv::Mat tag_image(dive::MarkerFamily family, int id) {
    const AprilTagFamily tags = make_april_tag_family(family);
    if (id < 0 || id >= static_cast<int>(tags->ncodes))
        throw Error(ErrorCode::InvalidArgument,
                    std::string(dive::to_string(family)) + " has no tag " + std::to_string(id) +
                        ": its ids are 0 to " + std::to_string(tags->ncodes - 1));
    const std::unique_ptr<image_u8_t, void (*)(image_u8_t*)> drawn(
        apriltag_to_image(tags.get(), id), image_u8_destroy);
    return cv::Mat(drawn->height, drawn->width, CV_8UC1, drawn->buf, drawn->stride).clone();
}

}  // namespace divemesh::markers
