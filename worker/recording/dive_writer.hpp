#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <unordered_map>
#include <vector>

#include "worker/base/atomic_file.hpp"
#include "worker/recording/image_file.hpp"
#include "worker/recording/provenance.hpp"
#include "worker/recording/rig_files.hpp"
#include "worker/types/recording.hpp"

namespace divemesh::recording {

enum class Side { Left, Right };

// Writes a dive in EuRoC layout beside its final name, `out`.partial, and gives it that name when
// it is complete and, unless unsynced, on disk. Without commit() the destructor removes it. Throws
// Error{Conflict} if `out` exists and is not an empty folder, and as AtomicFile does.
class DiveWriter {
public:
    explicit DiveWriter(std::filesystem::path out,
                        base::Durability durability = base::Durability::Synced);
    ~DiveWriter();
    DiveWriter(const DiveWriter&) = delete;
    DiveWriter& operator=(const DiveWriter&) = delete;

    // Writes an image; returns false for a second one of the same time, which is left out.
    bool add_image(Side side, std::int64_t timestamp_ns, const ImageFile& image);
    void add_imu(const types::ImuSample& sample) { imu_.push_back(sample); }
    // Adds to the times of all IMU rows that there are; one that no time is
    // left for, as before 1970, is left out.
    void move_imu(std::int64_t by_ns);
    void add_pressure(const types::PressureSample& sample) { pressure_.push_back(sample); }
    std::int64_t num_images(Side side) const;
    std::int64_t num_imu() const { return std::ssize(imu_); }
    std::int64_t num_pressures() const { return std::ssize(pressure_); }
    // Writes the tables, in the order of time, and gives the dive its name. `sources` is not empty;
    // the dive is named after the first.
    void commit(const RigFiles& rig, const Provenance& provenance);

private:
    using Names = std::unordered_map<std::int64_t, std::string>;  // of images, by timestamp

    void write_camera(Side side, const std::string& yaml) const;
    void write_imu(const std::string& yaml);
    void write_pressure();

    std::filesystem::path out_;
    std::filesystem::path partial_;
    base::Durability durability_;
    Names left_;
    Names right_;
    std::vector<types::ImuSample> imu_;
    std::vector<types::PressureSample> pressure_;
};

}  // namespace divemesh::recording
