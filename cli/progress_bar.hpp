#pragma once

#include <chrono>
#include <string>

namespace divemesh::cli {

// A progress line on stderr: a bar that is redrawn on a terminal, otherwise a line every ten
// seconds or when the label changes. The destructor removes it from the terminal.
class ProgressBar {
public:
    ProgressBar();
    ~ProgressBar();
    ProgressBar(const ProgressBar&) = delete;
    ProgressBar& operator=(const ProgressBar&) = delete;

    // fraction < 0: unknown.
    void show(const std::string& label, double fraction, const std::string& detail);
    // Prints a line of text above the bar.
    void say(const std::string& text);

private:
    bool is_terminal_;
    bool drawn_ = false;
    std::string label_;
    std::chrono::steady_clock::time_point drawn_at_{};
};

// Formats the rate over the last seconds and the remaining time.
class TransferMeter {
public:
    std::string detail(std::int64_t bytes_done, std::int64_t bytes_total);

private:
    std::chrono::steady_clock::time_point window_start_{};
    std::int64_t window_bytes_ = 0;
    double rate_ = 0.0;  // bytes per second, smoothed
};

}  // namespace divemesh::cli
