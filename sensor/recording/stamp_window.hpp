#pragma once

#include <cstdint>
#include <deque>
#include <optional>

namespace divemesh::sensor {

// The last time stamps of a stream with an even rate.
class StampWindow {
public:
    // Adds a stamp and returns how many are missing before it, by the rate so far. Ignores a stamp
    // that does not rise.
    std::int64_t add(std::int64_t timestamp_ns);
    std::optional<double> period_ns() const;  // the median; nullopt until there are a few
    std::optional<double> rate_hz() const;    // over the window
    std::optional<std::int64_t> newest_ns() const;

private:
    std::deque<std::int64_t> stamps_ns_;
};

}  // namespace divemesh::sensor
