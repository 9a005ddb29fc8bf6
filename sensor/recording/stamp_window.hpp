#pragma once

#include <cstdint>
#include <deque>
#include <optional>

namespace divemesh::sensor {

// The last time stamps of something that comes at an even rate.
class StampWindow {
public:
    // How many were left out before this one: gaps of the rate so far. A stamp that does not rise
    // is not taken.
    std::int64_t add(std::int64_t timestamp_ns);
    std::optional<double> period_ns() const;  // the median; nothing until there are a few
    std::optional<double> rate_hz() const;    // over the window
    std::optional<std::int64_t> newest_ns() const;

private:
    std::deque<std::int64_t> stamps_ns_;
};

}  // namespace divemesh::sensor
