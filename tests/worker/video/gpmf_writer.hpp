#pragma once

#include <cmath>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

namespace divemesh::video {

// Bytes of GPMF as its description states them: a key of four characters, the type, the size of a
// sample, how many there are, and the samples in big-endian, filled up to 4 bytes.
inline std::string klv(const std::string& key,
                       char type,
                       std::size_t sample_bytes,
                       std::size_t num_samples,
                       const std::string& value) {
    std::string bytes = key;
    bytes += type;
    bytes += static_cast<char>(sample_bytes);
    bytes += static_cast<char>(num_samples >> 8U);
    bytes += static_cast<char>(num_samples & 0xFFU);
    bytes += value;
    while (bytes.size() % 4 != 0) bytes += '\0';
    return bytes;
}

inline std::string big_endian_bytes(std::uint64_t value, std::size_t num_bytes) {
    std::string bytes;
    for (std::size_t i = num_bytes; i-- > 0;) bytes += static_cast<char>(value >> (8 * i) & 0xFFU);
    return bytes;
}

inline std::string shorts(const std::vector<int>& values) {
    std::string bytes;
    for (const int value : values) bytes += big_endian_bytes(static_cast<std::uint16_t>(value), 2);
    return bytes;
}

inline std::string longs(const std::vector<std::int64_t>& values) {
    std::string bytes;
    for (const std::int64_t value : values)
        bytes += big_endian_bytes(static_cast<std::uint32_t>(value), 4);
    return bytes;
}

// A list of keys as the value of one.
inline std::string nested(const std::string& key, const std::string& list) {
    return klv(key, '\0', 4, list.size() / 4, list);
}

// A stream of a sensor with three axes, each number divided by `scale` when it is read.
inline std::string sensor_stream(const std::string& key,
                                 int scale,
                                 const std::string& axes,
                                 std::uint32_t num_until_here,
                                 const std::vector<int>& values) {
    std::string list = klv("TSMP", 'L', 4, 1, big_endian_bytes(num_until_here, 4));
    list += klv("STNM", 'c', 1, 5, "motor");
    if (!axes.empty()) list += klv("ORIN", 'c', 1, axes.size(), axes);
    list += klv("SCAL", 's', 2, 1, shorts({scale}));
    list += klv(key, 's', 6, values.size() / 3, shorts(values));
    return nested("STRM", list);
}

// A stream of GPS5 as a HERO5 writes it: latitude and longitude in 1e-7 degrees, altitude, speeds.
inline std::string gps5_stream(unsigned lock,
                               unsigned hundredths_of_dop,
                               const std::vector<std::pair<double, double>>& fixes_deg) {
    std::vector<std::int64_t> numbers;
    for (const auto& [latitude_deg, longitude_deg] : fixes_deg)
        numbers.insert(
            numbers.end(),
            {std::llround(1e7 * latitude_deg), std::llround(1e7 * longitude_deg), 12'345, 100, 12});
    return nested("STRM",
                  klv("STNM", 'c', 1, 6, "GPS (L") +
                      klv("GPSF", 'L', 4, 1, big_endian_bytes(lock, 4)) +
                      klv("GPSU", 'U', 16, 1, "260501101112.123") +
                      klv("GPSP", 'S', 2, 1, big_endian_bytes(hundredths_of_dop, 2)) +
                      klv("SCAL", 'l', 4, 5, longs({10'000'000, 10'000'000, 1000, 1000, 100})) +
                      klv("GPS5", 'l', 20, fixes_deg.size(), longs(numbers)));
}

inline std::string device(const std::string& streams) {
    return nested("DEVC",
                  klv("DVID", 'L', 4, 1, big_endian_bytes(1, 4)) +
                      klv("DVNM", 'c', 1, 6, "Camera") + streams);
}

}  // namespace divemesh::video
