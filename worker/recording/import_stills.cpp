#include "worker/recording/import_stills.hpp"

#include <algorithm>
#include <array>
#include <utility>

#include "schemas/content_hash.hpp"
#include "schemas/error.hpp"
#include "worker/dive/entry_name.hpp"
#include "worker/recording/imu_clock.hpp"
#include "worker/recording/layout_rig.hpp"
#include "worker/recording/layout_sensors.hpp"

namespace divemesh::recording {
namespace {

constexpr std::array kPatterns = {"", "rggb", "bggr", "gbrg", "grbg"};
constexpr int kMinBits = 8;
constexpr int kMaxBits = 16;

[[noreturn]] void refuse(const std::string& what) { throw Error(ErrorCode::InvalidArgument, what); }

void check(const StillsOptions& options) {
    const auto& pixels = options.pixels;
    if (std::find(kPatterns.begin(), kPatterns.end(), pixels.bayer) == kPatterns.end())
        refuse("--bayer has to be rggb, bggr, gbrg or grbg: the colours of the first 2 x 2 pixels");
    if (pixels.num_bits != 0 && (pixels.num_bits < kMinBits || pixels.num_bits > kMaxBits))
        refuse("--bits has to be from 8 to 16");
    if (!options.imu.empty() && options.imu != "none")
        refuse("a folder of images has no topics: --imu can only be none");
    if (options.folders.size() > 2)
        refuse("give one folder, or that of the left camera and that of the right one");
    if (options.folders.size() == 2 && !(options.cameras.left + options.cameras.right).empty())
        refuse("with two folders the first is the left camera: leave out --left and --right");
}

// Checks options before folders are listed, which can take long.
StillsOptions checked(StillsOptions options) {
    check(options);
    if (options.folders.size() == 2) options.cameras = {"left", "right"};
    return options;
}

// Returns the name of a folder, with or without a slash at its end.
std::string name_of(std::filesystem::path folder) {
    if (!folder.has_filename()) folder = folder.parent_path();
    return std::filesystem::absolute(folder).lexically_normal().filename().string();
}

// Passes images on to a dive, one at a time, and hashes what was read.
class StillsWriter {
public:
    StillsWriter(const ImageFolders& folders,
                 const RigFiles& rig,
                 const PixelOptions& pixels,
                 DiveWriter& writer,
                 dive::FindingLog& findings)
        : folders_(folders), rig_(rig), pixels_(pixels), writer_(writer), findings_(findings) {}

    void add(Side side, const dive::CameraRow& row) {
        std::string bytes = folders_.read(row.file, kMaxStill_bytes);
        note(row.file, bytes);
        try {
            const ImageFile image = stored_image(std::move(bytes), pixels_);
            check_size(side, image, row.file);
            if (!writer_.add_image(side, row.timestamp_ns, image))
                findings_.warning("image_repeated",
                                  dive::printable(row.file),
                                  "a second image of time " + std::to_string(row.timestamp_ns) +
                                      " ns is left out",
                                  "");
        } catch (const Error& error) {
            if (error.code() != ErrorCode::BadData) throw;
            findings_.warning("image_undecodable",
                              dive::printable(row.file),
                              std::string("an image is left out: ") + error.what(),
                              "Copy it from the camera again, or export it as PNG.");
        }
    }

    void note(const std::string& name, const std::string& bytes) {
        hashed_.push_back({name, sha256_hex(bytes)});
        size_bytes_ += std::ssize(bytes);
    }

    Provenance provenance(const std::vector<std::filesystem::path>& folders, Naming naming) {
        std::string name;
        if (naming == Naming::AfterFile) name = name_of(folders.front());
        if (!name.empty() && folders.size() == 2) name += " and " + name_of(folders.back());
        return {.name = name,
                .files = {{name, content_sha256(std::move(hashed_)), size_bytes_}},
                .findings = findings_.all()};
    }

private:
    // Throws for an image of another size than the calibration's: Error{InvalidArgument} for the
    // first one, as the calibration is wrong for all of them then, Error{BadData} for a later one.
    void check_size(Side side, const ImageFile& image, const std::string& name) const {
        const types::Camera& camera = (side == Side::Left ? rig_.cam0 : rig_.cam1).camera;
        const auto& header = image.header;
        if (header.width_px == camera.width_px && header.height_px == camera.height_px) return;
        throw Error(writer_.num_images(side) == 0 ? ErrorCode::InvalidArgument : ErrorCode::BadData,
                    dive::printable(name) + " has " + std::to_string(header.width_px) + " x " +
                        std::to_string(header.height_px) + " px, its calibration is for " +
                        std::to_string(camera.width_px) + " x " + std::to_string(camera.height_px) +
                        ": state that of these images by --calibration");
    }

    const ImageFolders& folders_;
    const RigFiles& rig_;
    const PixelOptions& pixels_;
    DiveWriter& writer_;
    dive::FindingLog& findings_;
    std::vector<HashedFile> hashed_;
    std::int64_t size_bytes_ = 0;
};

}  // namespace

StillsImport::StillsImport(StillsOptions options, const base::ProgressCallback& progress)
    : options_(checked(std::move(options))),
      folders_(options_.folders, options_.scratch, findings_, progress, options_.links),
      sides_(find_camera_sides(folders_.images(), options_.cameras, findings_)),
      images_(pair_images(find_image_times(folders_, sides_, options_.times, findings_, progress),
                          findings_)) {}

ImportCounts StillsImport::write(const base::ProgressCallback& progress) {
    const RigFiles rig = find_rig();
    DiveWriter writer(options_.out, options_.durability);
    StillsWriter stills(folders_, rig, options_.pixels, writer, findings_);
    const auto num_images = static_cast<double>(images_.left.size() + images_.right.size());
    double num_done = 0.0;
    for (const auto& [side, rows] :
         {std::pair(Side::Left, &images_.left), std::pair(Side::Right, &images_.right)})
        for (const dive::CameraRow& row : *rows) {
            progress({"import", num_done++ / num_images});
            stills.add(side, row);
        }
    if (writer.num_images(Side::Left) == 0 || writer.num_images(Side::Right) == 0)
        throw Error(ErrorCode::BadData,
                    "no image of one of the cameras can be read: " + findings().back().message);
    add_sensors(rig, writer);
    writer.commit(rig, stills.provenance(options_.folders, options_.naming));
    return {writer.num_images(Side::Left),
            writer.num_images(Side::Right),
            writer.num_imu(),
            writer.num_pressures()};
}

RigFiles StillsImport::find_rig() {
    const ImageSize size = image_size(images_.left, "left");
    if (options_.is_uncalibrated) return uncalibrated_rig(size, image_size(images_.right, "right"));
    RigHints hints;
    hints.resolution = {static_cast<double>(size.width_px), static_cast<double>(size.height_px)};
    hints.metres_per_unit = options_.metres_per_unit;
    if (options_.calibration.empty())
        return rig_of_layout(options_.folders.front(), folders_, sides_, hints, findings_);
    return read_rig(options_.calibration, findings_, hints);
}

// Returns the size of the first image of a camera that is not damaged.
ImageSize StillsImport::image_size(const std::vector<dive::CameraRow>& rows,
                                   const char* camera) const {
    for (const dive::CameraRow& row : rows) try {
            const auto image =
                stored_image(folders_.read(row.file, kMaxStill_bytes), options_.pixels);
            return {image.header.width_px, image.header.height_px};
        } catch (const Error& error) {
            if (error.code() != ErrorCode::BadData) throw;
        }
    throw Error(
        ErrorCode::BadData,
        std::string("no image of the ") + camera + " camera can be read: export the images as PNG");
}

void StillsImport::add_sensors(const RigFiles& rig, DiveWriter& writer) {
    const auto folder = euroc_folder(sides_);
    if (!folder || options_.imu == "none" || options_.is_uncalibrated) return;
    if (folders_.has(*folder + "imu0/data.csv") && !rig.imu_yaml)
        findings_.warning("imu_left_out",
                          *folder + "imu0",
                          "the IMU is left out: where it is relative to the cameras is not known",
                          "State it by --calibration: T_BS of both cameras relative to the IMU.");
    add_layout_sensors(folders_, *folder, rig, writer, findings_);
    apply_imu_shift(rig, writer, findings_);
}

}  // namespace divemesh::recording
