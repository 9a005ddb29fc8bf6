#pragma once

#include <cstdint>
#include <filesystem>

namespace divemesh::bench {

// A change of a rendered dive, made before its reconstruction.
struct DiveChange {
    enum class Imu {
        AsIs,
        None,
        Mems,           // noise of a MEMS chip, stated correctly
        NoiseTooSmall,  // stated as a hundredth of the true noise
        NoiseTooLarge,  // stated as a hundred times the true noise
        Late,           // by 250 ms
        Mirrored,       // y of both sensors
        OtherDive,
        GyroscopeStops,  // noise alone, for four seconds from two fifths of the dive on
        ForcesDouble,    // for the same time
        BiasJumps,       // of the gyroscope, by 0.06 rad/s from two fifths of the dive on
        ClockJumps       // by 200 ms from two fifths of the dive on
    };

    int keep_every = 1;          // of the frames
    double overlap = 0.0;        // least, with the frame kept before; 0: keeps all frames
    double dropped_share = 0.0;  // of the frames, at random
    double doubled_share = 0.0;  // of the frames, at random; they repeat the image before
    double blue_at_share = 0.0;  // start of the stretch that shows only water, share of the dive
    double blue_s = 0.0;         // length of that stretch
    double gap_s = 0.0;          // length of a gap without frames in the middle
    double calibration_error = 0.0;         // as `simulate --calibration-error`
    double vertical_misalignment_px = 0.0;  // as `simulate --vertical-misalignment`
    double right_exposure = 1.0;            // of the right image, relative to the left
    Imu imu = Imu::AsIs;
};

// The rendered dives that write_changed() reads.
struct DiveSources {
    std::filesystem::path dive;
    std::filesystem::path other;  // source of the IMU for Imu::OtherDive
    std::filesystem::path blue;   // the same dive in images of water alone, for `blue_s`
};

// Writes a changed copy of a dive that `divemesh simulate --truth` rendered. Like a diver's
// recording, the copy has no AHRS, reference mesh or known lengths; it keeps the ground truth for
// evaluation. Images are hard links unless they change. Throws std::runtime_error if a file cannot
// be written.
void write_changed(const DiveSources& sources,
                   const DiveChange& change,
                   std::uint64_t seed,
                   const std::filesystem::path& out);

}  // namespace divemesh::bench
