#pragma once

#include <cstdint>
#include <filesystem>

namespace divemesh::bench {

// A change of a rendered dive, made before its reconstruction.
struct DiveChange {
    enum class Imu {
        AsIs,
        None,
        Mems,           // noise of a chip of a few euros, stated
        NoiseTooSmall,  // stated a hundredth of what it is
        NoiseTooLarge,  // stated a hundred times what it is
        Late,           // by 250 ms
        Mirrored,       // y of both sensors
        OtherDive
    };

    int keep_every = 1;              // of the frames
    double overlap = 0.0;            // with the frame kept before; 0: frames stay
    double dropped_share = 0.0;      // of the frames, drawn
    double doubled_share = 0.0;      // of the frames, drawn: they repeat the image before
    double blue_at_share = 0.0;      // where only water begins to be seen: 0 the start, 1 the end
    double blue_s = 0.0;             // and for how long
    double gap_s = 0.0;              // without frames, in the middle
    double calibration_error = 0.0;  // as `simulate --calibration-error`
    double vertical_misalignment_px = 0.0;  // as `simulate --vertical-misalignment`
    double right_exposure = 1.0;            // of the right image, times that of the left
    Imu imu = Imu::AsIs;
};

// The rendered dives that a changed one is made of.
struct DiveSources {
    std::filesystem::path dive;
    std::filesystem::path other;  // of Imu::OtherDive
    std::filesystem::path blue;   // the same dive, only water is seen; for `blue_s`
};

// Writes a changed copy of a dive that `divemesh simulate --truth` rendered, as divers bring one:
// without AHRS, reference mesh and known lengths; ground truth stays, to be compared with. Images
// are hard links unless they change. Throws std::runtime_error if a file cannot be written.
void write_changed(const DiveSources& sources,
                   const DiveChange& change,
                   std::uint64_t seed,
                   const std::filesystem::path& out);

}  // namespace divemesh::bench
