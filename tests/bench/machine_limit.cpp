#include "tests/bench/machine_limit.hpp"

#include <algorithm>
#include <ctime>
#include <linux/perf_event.h>
#include <sys/ioctl.h>
#include <sys/syscall.h>
#include <unistd.h>

namespace divemesh::bench {
namespace {

constexpr int kNumAccumulators = 12;
constexpr int kNumRounds = 1'000'000;

template <int kBytes>
using Bytes = std::uint8_t __attribute__((vector_size(kBytes)));

// Two operations per accumulator and round; the sums count as used.
template <int kBytes>
DIVEMESH_INLINE_BODY void operate_body() {
    Bytes<kBytes> sums[kNumAccumulators] = {};
    const Bytes<kBytes> step = Bytes<kBytes>{} + std::uint8_t{3};
    const Bytes<kBytes> limit = Bytes<kBytes>{} + std::uint8_t{200};
    for (int round = 0; round < kNumRounds; ++round)
        for (auto& sum : sums) {
            sum += step;
            sum = sum < limit ? sum : limit;
        }
    asm volatile("" : : "m"(sums));
}

void operate() { operate_body<16>(); }
#if defined(__x86_64__)
DIVEMESH_FOR_AVX2 void operate_avx2() { operate_body<32>(); }
__attribute__((target("avx512f,avx512bw"))) void operate_avx512() { operate_body<64>(); }
#endif

double cpu_s() {
    timespec now{};
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
    return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

double measure(void (*run)(), int num_bytes) {
    double least_s = 1e9;
    for (int i = 0; i < 5; ++i) {
        const double start_s = cpu_s();
        run();
        least_s = std::min(least_s, cpu_s() - start_s);
    }
    return 2.0 * kNumAccumulators * kNumRounds * num_bytes / least_s;
}

}  // namespace

InstructionCounter::InstructionCounter() {
    perf_event_attr what{};
    what.type = PERF_TYPE_HARDWARE;
    what.size = sizeof what;
    what.config = PERF_COUNT_HW_INSTRUCTIONS;
    what.disabled = 1;
    what.exclude_kernel = 1;
    what.exclude_hv = 1;
    file_ = static_cast<int>(syscall(SYS_perf_event_open, &what, 0, -1, -1, 0));
}

InstructionCounter::~InstructionCounter() {
    if (file_ >= 0) close(file_);
}

void InstructionCounter::start() {
    if (file_ < 0) return;
    ioctl(file_, PERF_EVENT_IOC_RESET, 0);
    ioctl(file_, PERF_EVENT_IOC_ENABLE, 0);
}

std::optional<std::uint64_t> InstructionCounter::stop() {
    std::uint64_t count = 0;
    if (file_ < 0) return std::nullopt;
    ioctl(file_, PERF_EVENT_IOC_DISABLE, 0);
    if (read(file_, &count, sizeof count) != sizeof count || count == 0) return std::nullopt;
    return count;
}

double byte_operations_per_s(worker::Instructions instructions) {
#if defined(__x86_64__)
    if (instructions == worker::Instructions::Avx512) return measure(operate_avx512, 64);
    if (instructions == worker::Instructions::Avx2) return measure(operate_avx2, 32);
#endif
    return measure(operate, 16);
}

}  // namespace divemesh::bench
