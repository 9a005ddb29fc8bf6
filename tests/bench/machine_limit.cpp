#include "tests/bench/machine_limit.hpp"

#include <algorithm>
#include <ctime>
#include <linux/perf_event.h>
#include <numeric>
#include <sys/ioctl.h>
#include <sys/syscall.h>
#include <unistd.h>
#include <vector>

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
__attribute__((target("avx2"))) void operate_avx2() { operate_body<32>(); }
__attribute__((target("avx512f,avx512bw"))) void operate_avx512() { operate_body<64>(); }
#endif

// The best of five.
template <typename Run>
double min_cpu_s(Run&& run) {
    double min_duration_s = 1e9;
    for (int i = 0; i < 5; ++i) {
        const double start_s = thread_cpu_s();
        run();
        min_duration_s = std::min(min_duration_s, thread_cpu_s() - start_s);
    }
    return min_duration_s;
}

double operations_per_s(void (*run)(), int num_bytes) {
    return 2.0 * kNumAccumulators * kNumRounds * num_bytes / min_cpu_s(run);
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
    file_ = FileDescriptor(static_cast<int>(syscall(SYS_perf_event_open, &what, 0, -1, -1, 0)));
}

void InstructionCounter::start() {
    if (!file_.is_open()) return;
    ioctl(file_.get(), PERF_EVENT_IOC_RESET, 0);
    ioctl(file_.get(), PERF_EVENT_IOC_ENABLE, 0);
}

std::optional<std::uint64_t> InstructionCounter::stop() {
    std::uint64_t count = 0;
    if (!file_.is_open()) return std::nullopt;
    ioctl(file_.get(), PERF_EVENT_IOC_DISABLE, 0);
    if (read(file_.get(), &count, sizeof count) != sizeof count || count == 0) return std::nullopt;
    return count;
}

double thread_cpu_s() {
    timespec now{};
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
    return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

double byte_operations_per_s(base::Instructions instructions) {
#if defined(__x86_64__)
    if (instructions == base::Instructions::Avx512) return operations_per_s(operate_avx512, 64);
    if (instructions == base::Instructions::Avx2) return operations_per_s(operate_avx2, 32);
#endif
    return operations_per_s(operate, 16);
}

double bytes_read_per_s() {
    constexpr std::size_t kNumWords = std::size_t{1} << 24;  // 128 MB: more than any cache holds
    const std::vector<std::uint64_t> words(kNumWords, 1);
    const double read_s = min_cpu_s([&] {
        const auto sum = std::accumulate(words.begin(), words.end(), std::uint64_t{0});
        asm volatile("" : : "r"(sum));
    });
    return sizeof(std::uint64_t) * static_cast<double>(kNumWords) / read_s;
}

}  // namespace divemesh::bench
