#include <algorithm>
#include <atomic>
#include <charconv>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <iterator>
#include <sanitizer/common_interface_defs.h>
#include <string>
#include <string_view>
#include <sys/resource.h>
#include <sys/time.h>
#include <unistd.h>
#include <vector>

#include "tests/fuzz/mutator.hpp"

// Runs a fuzz target where there is no libFuzzer: the corpus, then what the mutator makes of it.
// Takes libFuzzer's flags, of which it heeds those below, and folders; one file is run once.

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size);

namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;

struct Flags {
    int max_total_time = 60;
    std::size_t max_len = 4096;
    unsigned timeout = 10;
    long rss_limit_mb = 2048;
    std::uint64_t seed = 1;
    std::string artifact_prefix;
};

// What the input is kept by when the process ends under it.
std::string current_input;
std::string artifact;

void keep_input(const char* why) {
    static std::atomic_flag kept;
    if (kept.test_and_set()) return;
    if (std::FILE* file = std::fopen(artifact.c_str(), "wb")) {
        std::fwrite(current_input.data(), 1, current_input.size(), file);
        std::fclose(file);
    }
    std::fprintf(stderr, "%s; the input is in %s\n", why, artifact.c_str());
}

void keep_on_abort(int) {
    keep_input("aborted");
    std::_Exit(77);
}

void keep_on_timeout(int) {
    keep_input("took too long");
    std::_Exit(70);
}

void keep_on_report() { keep_input("a sanitizer ended it"); }

template <typename Number>
void read_flag(std::string_view flag, std::string_view name, Number& value) {
    if (flag.starts_with(name))
        std::from_chars(flag.data() + name.size(), flag.data() + flag.size(), value);
}

Flags read_flags(const std::vector<std::string>& arguments) {
    constexpr std::string_view kPrefix = "-artifact_prefix=";
    Flags flags;
    for (const auto& argument : arguments) {
        read_flag(argument, "-max_total_time=", flags.max_total_time);
        read_flag(argument, "-max_len=", flags.max_len);
        read_flag(argument, "-timeout=", flags.timeout);
        read_flag(argument, "-rss_limit_mb=", flags.rss_limit_mb);
        read_flag(argument, "-seed=", flags.seed);
        if (argument.starts_with(kPrefix)) flags.artifact_prefix = argument.substr(kPrefix.size());
    }
    return flags;
}

std::string read_file(const fs::path& path) {
    std::ifstream file(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
}

std::vector<std::string> read_corpus(const fs::path& folder) {
    std::vector<fs::path> files;
    for (const auto& entry : fs::directory_iterator(folder))
        if (entry.is_regular_file()) files.push_back(entry.path());
    std::sort(files.begin(), files.end());
    std::vector<std::string> inputs;
    for (const auto& file : files) inputs.push_back(read_file(file));
    return inputs;
}

// Counts the seconds that the process computes, so that a busy machine fails no input, and six
// times as many that pass, so that one that waits for ever ends too. 0 stops both.
void limit_time(unsigned seconds) {
    const itimerval computed{{0, 0}, {static_cast<time_t>(seconds), 0}};
    setitimer(ITIMER_PROF, &computed, nullptr);
    alarm(6 * seconds);
}

// In memory of its own size, so that a read beyond its end is seen.
void run(std::string input, const Flags& flags) {
    static std::size_t count = 0;
    artifact = flags.artifact_prefix + "crash-" + std::to_string(++count);
    current_input = std::move(input);
    const std::vector<std::uint8_t> bytes(current_input.begin(), current_input.end());
    limit_time(flags.timeout);
    LLVMFuzzerTestOneInput(bytes.data(), bytes.size());
    limit_time(0);
    rusage usage{};
    getrusage(RUSAGE_SELF, &usage);
    if (usage.ru_maxrss / 1024 < flags.rss_limit_mb) return;
    keep_input("took too much memory");
    std::_Exit(71);
}

std::size_t run_until(Clock::time_point end,
                      const std::vector<std::string>& corpus,
                      const Flags& flags) {
    for (const auto& input : corpus) run(input, flags);
    divemesh::fuzz::Mutator mutator(corpus, flags.seed, flags.max_len);
    std::size_t executions = corpus.size();
    for (; Clock::now() < end; ++executions) run(mutator.next(), flags);
    return executions;
}

}  // namespace

int main(int argc, char** argv) {
    const std::vector<std::string> arguments(argv + 1, argv + argc);
    const Flags flags = read_flags(arguments);
    std::signal(SIGABRT, keep_on_abort);
    std::signal(SIGALRM, keep_on_timeout);
    std::signal(SIGPROF, keep_on_timeout);
    __sanitizer_set_death_callback(keep_on_report);

    const auto end = Clock::now() + std::chrono::seconds(flags.max_total_time);
    std::vector<std::string> corpus;
    for (const auto& argument : arguments) {
        if (argument.starts_with('-')) continue;
        if (fs::is_regular_file(argument)) {
            run(read_file(argument), flags);
            return 0;
        }
        const auto inputs = read_corpus(argument);
        corpus.insert(corpus.end(), inputs.begin(), inputs.end());
    }
    // As libFuzzer says it.
    std::cerr << "stat::number_of_executed_units: " << run_until(end, corpus, flags) << "\n";
}
