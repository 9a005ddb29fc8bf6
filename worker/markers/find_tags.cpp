#include "worker/markers/find_tags.hpp"

#include <algorithm>

#include "worker/markers/april_tag.hpp"

namespace divemesh::markers {
namespace {

// A detector with its family; the library frees a family's tables only when it is removed from its
// detector.
class Detector {
public:
    Detector(dive::MarkerFamily family, int num_more_cells)
        : family_(make_april_tag_family(family)), detector_(apriltag_detector_create()) {
        widen(*family_, num_more_cells);
        detector_->nthreads = 1;
        detector_->quad_decimate = 1.0F;
        apriltag_detector_add_family_bits(detector_, family_.get(), 0);
    }
    ~Detector() {
        apriltag_detector_remove_family(detector_, family_.get());
        apriltag_detector_destroy(detector_);
    }
    Detector(const Detector&) = delete;
    Detector& operator=(const Detector&) = delete;

    std::vector<Tag> detect(const cv::Mat& grey) {
        image_u8_t image = {grey.cols,
                            grey.rows,
                            static_cast<int>(grey.step),
                            const_cast<std::uint8_t*>(grey.data)};
        zarray_t* found = apriltag_detector_detect(detector_, &image);
        std::vector<Tag> tags;
        for (int i = 0; i < zarray_size(found); ++i) {
            apriltag_detection_t* detection = nullptr;
            zarray_get(found, i, &detection);
            if (detection->hamming == 0) tags.push_back(tag_of(*detection));
        }
        apriltag_detections_destroy(found);
        return tags;
    }

private:
    static void widen(apriltag_family_t& family, int num_more_cells) {
        family.width_at_border += 2 * num_more_cells;
        family.total_width += 2 * num_more_cells;
        for (std::uint32_t i = 0; i < family.nbits; ++i) {
            family.bit_x[i] += static_cast<std::uint32_t>(num_more_cells);
            family.bit_y[i] += static_cast<std::uint32_t>(num_more_cells);
        }
    }
    static Tag tag_of(const apriltag_detection_t& detection) {
        Tag tag;
        tag.id = detection.id;
        constexpr double kCenter_px = 0.5;  // centre of the first pixel in the library's convention
        for (std::size_t i = 0; i < dive::kNumTagCorners; ++i)
            tag.corners_px[i] = {detection.p[i][0] - kCenter_px, detection.p[i][1] - kCenter_px};
        return tag;
    }

    AprilTagFamily family_;
    apriltag_detector_t* detector_;
};

bool comes_before(const Tag& a, const Tag& b) {
    if (a.id != b.id) return a.id < b.id;
    return std::lexicographical_compare(a.corners_px[0].begin(),
                                        a.corners_px[0].end(),
                                        b.corners_px[0].begin(),
                                        b.corners_px[0].end());
}

}  // namespace

std::vector<Tag> find_tags(const cv::Mat& grey, dive::MarkerFamily family) {
    std::vector<Tag> tags = Detector(family, 0).detect(grey);
    const TagLayout layout = tag_layout(family);
    for (Tag& tag : tags) refine_corners(grey, layout, tag);
    std::sort(tags.begin(), tags.end(), comes_before);
    return tags;
}

std::vector<Tag> find_wide_tags(const cv::Mat& grey,
                                dive::MarkerFamily family,
                                int num_more_cells) {
    std::vector<Tag> tags = Detector(family, num_more_cells).detect(grey);
    std::sort(tags.begin(), tags.end(), comes_before);
    return tags;
}

}  // namespace divemesh::markers
