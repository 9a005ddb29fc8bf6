#include "worker/io/posed_images.hpp"

#include <cmath>
#include <cstdio>
#include <fstream>
#include <iterator>
#include <set>

#include "schemas/error.hpp"
#include "schemas/jpeg_header.hpp"
#include "worker/base/atomic_file.hpp"
#include "worker/base/parallel.hpp"
#include "worker/io/jpeg.hpp"

namespace divemesh::io {
namespace {

namespace fs = std::filesystem;

constexpr double kMaxSide_px = 65'535.0;  // of a JPEG
constexpr int kWholeQuality = 95;         // for programs that learn from the images

[[noreturn]] void fail(const fs::path& file, const std::string& what) {
    throw Error(ErrorCode::BadData,
                file.string() + ": " + what +
                    ": copy the reconstruction again, or reconstruct the dive again");
}

JpegSize size_of(const fs::path& file) {
    const std::string bytes = read_image_bytes(file);
    try {
        return read_jpeg_size(bytes);
    } catch (const Error& error) {
        fail(file, error.what());
    }
}

// Returns the size that all small images have.
JpegSize small_size(const std::vector<PosedImage>& images) {
    const JpegSize size = size_of(images.front().file);
    for (const PosedImage& image : images) {
        const JpegSize found = size_of(image.file);
        if (found.width != size.width || found.height != size.height)
            fail(image.file, "the image differs in size from the other keyframes");
    }
    return size;
}

void check_camera(const KeyframeCamera& whole, const fs::path& file) {
    if (!(whole.size_px.minCoeff() >= 1.0 && whole.size_px.maxCoeff() <= kMaxSide_px))
        fail(file, "image_size_px is no image size");
    if (!(whole.focal_px > 0.0)) fail(file, "focal_px is no focal length");
}

JpegSize whole_size(const KeyframeCamera& camera) {
    return {static_cast<int>(camera.size_px.x()), static_cast<int>(camera.size_px.y())};
}

// Returns the camera of images that are `size` large, from that of the whole rectified images.
PosedImages camera_of(const KeyframeCamera& whole, const JpegSize& size, const fs::path& file) {
    const double scale = size.width / whole.size_px.x();
    if (std::abs(scale * whole.size_px.y() - size.height) > 1.0)
        fail(file, "the images in keyframes/ have another shape than image_size_px");
    return {.width_px = size.width,
            .height_px = size.height,
            .focal_px = scale * whole.focal_px,
            .center_px = scale * (whole.center_px + Eigen::Vector2d::Constant(0.5)),
            .images = {},
            .whole = {}};
}

std::vector<PosedImage> images_of(const ReconstructionFolder& reconstruction) {
    std::vector<PosedImage> images;
    for (const KeyframePose& keyframe : reconstruction.keyframes()) {
        char name[40];
        std::snprintf(name, sizeof name, "%06d.jpg", keyframe.frame_index);
        images.push_back({name,
                          reconstruction.path() / "keyframes" / name,
                          keyframe.frame_index,
                          keyframe.T_world_cam});
    }
    return images;
}

}  // namespace

std::string read_image_bytes(const fs::path& file) {
    std::ifstream stream(file, std::ios::binary);
    if (!stream)
        throw Error(ErrorCode::NotFound,
                    "cannot open the keyframe's image " + file.string() +
                        ": copy the folder keyframes/ of the reconstruction too");
    return {std::istreambuf_iterator<char>(stream), {}};
}

PosedImages read_posed_images(const ReconstructionFolder& reconstruction, const WholeImage& whole) {
    const fs::path file = reconstruction.path() / "keyframes.json";
    std::vector<PosedImage> images = images_of(reconstruction);
    if (images.empty()) fail(file, "it has no keyframes");
    std::set<std::string> names;
    for (const PosedImage& image : images) {
        if (!names.insert(image.name).second) fail(file, image.name + " is there twice");
        if (!image.T_world_cam.matrix().allFinite()) fail(file, image.name + " has no finite pose");
    }
    const KeyframeCamera camera = reconstruction.keyframe_camera();
    check_camera(camera, file);
    PosedImages result = camera_of(camera, whole ? whole_size(camera) : small_size(images), file);
    result.images = std::move(images);
    result.whole = whole;
    return result;
}

void write_images(const PosedImages& images, const fs::path& folder) {
    fs::create_directories(folder);
    base::for_each_index(0, images.images.size(), [&](std::size_t i) {
        const PosedImage& image = images.images[i];
        base::write_file(folder / image.name,
                         images.whole ? encode_jpeg(images.whole(image.frame_index), kWholeQuality)
                                      : read_image_bytes(image.file),
                         base::Durability::Unsynced);
    });
}

}  // namespace divemesh::io
