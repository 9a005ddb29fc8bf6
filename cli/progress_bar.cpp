#include "cli/progress_bar.hpp"

#include <algorithm>
#include <array>
#include <cstdio>
#include <iostream>
#include <unistd.h>

#include "cli/text.hpp"

namespace divemesh::cli {
namespace {

using Clock = std::chrono::steady_clock;

constexpr std::chrono::milliseconds kTerminalPause{100};
constexpr std::chrono::seconds kLinePause{10};
constexpr std::chrono::milliseconds kRateWindow{1000};
constexpr int kBarWidth = 24;

}  // namespace

ProgressBar::ProgressBar() : is_terminal_(::isatty(STDERR_FILENO) != 0) {}

ProgressBar::~ProgressBar() {
    if (is_terminal_ && drawn_) std::cerr << "\r\x1b[K" << std::flush;
}

void ProgressBar::show(const std::string& label, double fraction, const std::string& detail) {
    const auto now = Clock::now();
    const bool due = now - drawn_at_ >=
                     (is_terminal_ ? Clock::duration(kTerminalPause) : Clock::duration(kLinePause));
    if (label == label_ && !due && !(is_terminal_ && fraction >= 1.0)) return;
    label_ = label;
    drawn_at_ = now;
    drawn_ = true;
    std::array<char, 8> percent{};
    if (fraction >= 0.0)
        std::snprintf(percent.data(), percent.size(), "%3.0f %%", std::min(fraction, 1.0) * 100.0);
    if (!is_terminal_) {
        std::string line = label + ' ' + percent.data() + "  " + detail;
        line.erase(line.find_last_not_of(' ') + 1);
        std::cerr << line << std::endl;
        return;
    }
    const int filled =
        static_cast<int>(std::clamp(fraction, 0.0, 1.0) * static_cast<double>(kBarWidth));
    std::string bar(static_cast<std::size_t>(filled), '#');
    bar.resize(kBarWidth, '.');
    std::cerr << "\r\x1b[K" << label << " [" << bar << "] " << percent.data() << "  " << detail
              << std::flush;
}

void ProgressBar::say(const std::string& text) {
    if (is_terminal_ && drawn_) std::cerr << "\r\x1b[K";
    std::cerr << text << std::endl;
    drawn_at_ = {};
}

std::string TransferMeter::detail(std::int64_t bytes_done, std::int64_t bytes_total) {
    const auto now = Clock::now();
    if (window_start_ == Clock::time_point{}) {
        window_start_ = now;
        window_bytes_ = bytes_done;
    }
    const auto elapsed = std::chrono::duration<double>(now - window_start_);
    if (elapsed >= kRateWindow) {
        const double rate =
            std::max(0.0, static_cast<double>(bytes_done - window_bytes_) / elapsed.count());
        rate_ = rate_ == 0.0 ? rate : 0.7 * rate_ + 0.3 * rate;
        window_start_ = now;
        window_bytes_ = bytes_done;
    }
    std::string text = bytes_text(static_cast<double>(bytes_done)) + " of " +
                       bytes_text(static_cast<double>(bytes_total));
    if (rate_ > 0.0)
        text += ", " + bytes_text(rate_) + "/s, " +
                duration_text(static_cast<double>(bytes_total - bytes_done) / rate_) + " left";
    return text;
}

}  // namespace divemesh::cli
