#include <algorithm>
#include <fstream>
#include <iterator>
#include <memory>

#include "worker/base/atomic_file.hpp"
#include "worker/base/part_of.hpp"
#include "worker/camera/small_left_images.hpp"
#include "worker/color/restored_images.hpp"
#include "worker/io/glb_writer.hpp"
#include "worker/io/mosaic_files.hpp"
#include "worker/keyframes/keyframe_images.hpp"
#include "worker/mosaic/mosaic_grid.hpp"
#include "worker/mosaic/mosaic_renderer.hpp"
#include "worker/mosaic/texel_size.hpp"
#include "worker/mosaic/thumbnail.hpp"
#include "worker/pipeline/display_mesh.hpp"
#include "worker/pipeline/link_or_copy.hpp"
#include "worker/pipeline/stage_functions.hpp"

namespace divemesh::pipeline {
namespace {

namespace fs = std::filesystem;

// Shares of the work that are done: of the whole, and of what kDisplayed covers.
constexpr double kDisplayed = 0.9;
constexpr double kTextured = 0.8;
constexpr int kRows = 256;                           // of the mosaic, rendered at once
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

// Returns what reads the photographs without the water, from what reads them as recorded; or that
// itself, if this was not asked or is not possible.
keyframes::ReadImage shown_images(const Reconstruction& made,
                                  const keyframes::ReadImage& recorded) {
    if (!made.color || !made.color->fit.is_known()) return recorded;
    return color::restored_images(made.surface.mesh,
                                  made.optimised.rig,
                                  made.optimised.keyframes,
                                  recorded,
                                  color::Restorer(made.color->fit, made.color->white));
}

// Returns the surface as viewers show it: with the photographs, or as it is where there is none.
DisplayMesh displayed(const Reconstruction& made, const base::ProgressCallback& progress) {
    const types::Mesh& surface = made.surface.mesh;
    if (!made.options().texture || surface.triangles.empty())
        return {surface, {}, {.num_triangles = std::ssize(surface.triangles)}};
    const keyframes::ReadImage recorded = [&made](int frame_index) {
        return made.keyframe_store.left_in_color(frame_index);
    };
    return make_display_mesh(surface,
                             made.optimised.rig,
                             made.optimised.keyframes,
                             recorded,
                             shown_images(made, recorded),
                             made.options().num_threads,
                             progress);
}

// Writes the mosaic and its thumbnail; returns the size of its pixels, m.
double write_mosaic(const Reconstruction& made,
                    const DisplayMesh& shown,
                    const fs::path& folder,
                    const base::ProgressCallback& progress) {
    const types::RasterGrid grid =
        mosaic::mosaic_grid(shown.mesh, mosaic::seen_pixel_m(shown.mesh, shown.texture));
    const int num_threads = made.options().num_threads;
    const mosaic::MosaicRenderer renderer(shown.mesh, &shown.texture, grid, num_threads);
    io::MosaicWriter writer(folder, grid, made.position(), num_threads);
    for (int row = 0; row < grid.height_px; row += kRows) {
        const mosaic::MosaicRows rows = renderer.rows(row, std::min(kRows, grid.height_px - row));
        writer.append(rows.color, rows.height_m, rows.sigma_m);
        Progress reached;
        reached.fraction = static_cast<double>(row) / grid.height_px;
        progress(reached);
    }
    writer.commit();
    base::write_file(folder / kThumbnail, mosaic::thumbnail_png(writer.preview()));
    return grid.pixel_m;
}

// Writes mesh.glb and, with the photographs, the mosaic; returns what is known of them.
TextureMetrics write_surface(const Reconstruction& made,
                             const fs::path& folder,
                             const base::ProgressCallback& progress) {
    const DisplayMesh shown = displayed(made, base::part_of(progress, 0.0, kTextured));
    const bool is_textured = !shown.texture.atlas_of_triangle.empty();
    io::write_glb(folder / "mesh.glb",
                  shown.mesh,
                  is_textured ? &shown.texture : nullptr,
                  io::GlbCompression::Meshopt);
    TextureMetrics metrics = shown.metrics;
    if (made.options().texture)
        metrics.mosaic_pixel_m =
            write_mosaic(made, shown, folder, base::part_of(progress, kTextured, 1.0));
    return metrics;
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
    made.texture = write_surface(made, folder, base::part_of(progress, 0.0, kDisplayed));
    keyframes::write_keyframe_images(folder,
                                     made.optimised.rig,
                                     made.optimised.keyframes,
                                     keyframe_images(made),
                                     made.options().num_threads,
                                     base::part_of(progress, kDisplayed, 1.0));
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
