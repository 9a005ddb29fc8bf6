#include "sensor/clock/uptime.hpp"

#include <chrono>
#include <ctime>
#include <sys/timex.h>

namespace divemesh::sensor {
namespace {

std::int64_t since_boot_ms() {
    timespec time{};
    clock_gettime(CLOCK_BOOTTIME, &time);
    return std::int64_t{time.tv_sec} * 1000 + time.tv_nsec / 1'000'000;
}

const std::int64_t kStart_ms = since_boot_ms();

}  // namespace

std::int64_t uptime_ms() { return since_boot_ms() - kStart_ms; }

std::int64_t wall_time_ms() {
    return std::chrono::duration_cast<std::chrono::milliseconds>(
               std::chrono::system_clock::now().time_since_epoch())
        .count();
}

bool is_wall_time_synchronised() {
    timex state{};
    return adjtimex(&state) != TIME_ERROR;
}

}  // namespace divemesh::sensor
