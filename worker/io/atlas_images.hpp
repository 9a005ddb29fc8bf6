#pragma once

#include <cstdint>
#include <list>
#include <opencv2/core/mat.hpp>
#include <vector>

#include "worker/io/textured_mesh.hpp"

namespace divemesh::io {

// The atlases of a stored texture, decoded when they are asked for. Those used last are kept, up to
// 512 MiB.
class AtlasImages {
public:
    // Throws Error{BadData} if an atlas is no JPEG or larger than 8192 px a side, before it decodes
    // one.
    explicit AtlasImages(const StoredTexture& texture);

    const cv::Size& size(std::int32_t atlas) const { return sizes_[atlas]; }
    // Returns an atlas, CV_8UC3 BGR. Throws Error{BadData} if it cannot be decoded.
    cv::Mat image(std::int32_t atlas);

private:
    struct Decoded {
        std::int32_t atlas;
        cv::Mat image;
    };

    const StoredTexture& texture_;
    std::vector<cv::Size> sizes_;
    std::list<Decoded> decoded_;  // the one used last at the front
};

}  // namespace divemesh::io
