#include "sensor/clock/uptime.hpp"

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

bool is_wall_time_synchronised() {
    timex state{};
    return adjtimex(&state) != TIME_ERROR;
}

}  // namespace divemesh::sensor
