#include <fstream>
#include <iterator>
#include <memory>

#include "worker/base/atomic_file.hpp"
#include "worker/base/part_of.hpp"
#include "worker/camera/small_left_images.hpp"
#include "worker/io/glb_writer.hpp"
#include "worker/keyframes/keyframe_images.hpp"
#include "worker/mosaic/mosaic.hpp"
#include "worker/pipeline/display_mesh.hpp"
#include "worker/pipeline/link_or_copy.hpp"
#include "worker/pipeline/stage_functions.hpp"

namespace divemesh::pipeline {
namespace {

namespace fs = std::filesystem;

constexpr double kDisplayed = 0.8;                   // share of the work that is done then
constexpr const char* kThumbnail = "thumbnail.png";  // for report.html, not an artifact

// Returns what reads the images of keyframes. Those of a rolling shutter are moved by their depth,
// which takes all of their pixels.
keyframes::ReadImage keyframe_images(const Reconstruction& made) {
    if (made.shutter)
        return [&made](int frame_index) { return made.keyframe_store.left_in_color(frame_index); };
    const types::RefinedCalibration& calibration = made.optimised.calibration;
    camera::RectifiedLens left = camera::rectified_lenses(made.recording.rig())[0];
    if (calibration.lenses_applied)
        left.camera = camera::changed_camera(left.camera, calibration.lenses[0]);
    return [images = std::make_shared<const camera::SmallLeftImages>(made.recording,
                                                                     left,
                                                                     made.track.rig,
                                                                     keyframes::kImageWidth_px,
                                                                     made.options().num_threads)](
               int frame_index) { return images->read(frame_index); };
}

TextureMetrics write_glb(const Reconstruction& made,
                         const fs::path& file,
                         const base::ProgressCallback& progress) {
    const types::Mesh& surface = made.surface.mesh;
    if (!made.options().texture || surface.triangles.empty()) {
        io::write_glb(file, surface, nullptr, io::GlbCompression::Meshopt);
        return {.num_triangles = std::ssize(surface.triangles)};
    }
    const DisplayMesh shown = make_display_mesh(
        surface,
        made.optimised.rig,
        made.optimised.keyframes,
        [&made](int frame_index) { return made.keyframe_store.left_in_color(frame_index); },
        made.options().num_threads,
        progress);
    io::write_glb(file, shown.mesh, &shown.texture, io::GlbCompression::Meshopt);
    return shown.metrics;
}

std::string read_text(const fs::path& file) {
    std::ifstream stream(file, std::ios::binary);
    return {std::istreambuf_iterator<char>(stream), {}};
}

}  // namespace

bool load_texture(Reconstruction& made, const std::string& key) {
    const auto stored = load_texture_metrics(made.scratch("texture.stage"), key);
    if (stored) made.texture = *stored;
    return stored.has_value();
}

void run_texture(Reconstruction& made, const base::ProgressCallback& progress) {
    const fs::path folder = made.scratch("texture");
    fs::create_directories(folder);
    made.texture = write_glb(made, folder / "mesh.glb", base::part_of(progress, 0.0, kDisplayed));
    keyframes::write_keyframe_images(folder,
                                     made.optimised.rig,
                                     made.optimised.keyframes,
                                     keyframe_images(made),
                                     made.options().num_threads,
                                     base::part_of(progress, kDisplayed, 1.0));
    if (!made.options().texture) return;
    const mosaic::Mosaic mosaic = mosaic::render_mosaic(made.surface.mesh);
    mosaic::write_mosaic(folder, mosaic);
    base::write_file(folder / kThumbnail, mosaic::thumbnail_png(mosaic));
}

void save_texture(Reconstruction& made, const std::string& key) {
    save_texture_metrics(made.scratch("texture.stage"), key, made.texture);
}

void finish_texture(Reconstruction& made) {
    const fs::path folder = made.scratch("texture");
    const fs::path thumbnail = folder / kThumbnail;
    if (fs::exists(thumbnail)) made.thumbnail_png = read_text(thumbnail);
    for (const auto& file : fs::recursive_directory_iterator(folder))
        if (file.is_regular_file() && file.path() != thumbnail)
            link_or_copy(file.path(), made.artifact(file.path().lexically_relative(folder)));
    made.mesh_writer.wait();
    made.border_finder.wait();
}

}  // namespace divemesh::pipeline
