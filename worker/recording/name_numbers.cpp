#include "worker/recording/name_numbers.hpp"

#include <algorithm>

namespace divemesh::recording {
namespace {

constexpr std::string_view kDigits = "0123456789";

// Returns the first run of digits from a place on; "" at the end.
std::string_view digits_from(std::string_view text, std::size_t begin) {
    const std::size_t first = text.find_first_of(kDigits, begin);
    if (first == std::string_view::npos) return text.substr(text.size());
    const std::size_t end = std::min(text.find_first_not_of(kDigits, first), text.size());
    return text.substr(first, end - first);
}

std::size_t end_of(std::string_view part, std::string_view text) {
    return static_cast<std::size_t>(part.data() - text.data()) + part.size();
}

}  // namespace

std::string last_number(std::string_view stem) {
    std::string_view last;
    for (auto run = digits_from(stem, 0); !run.empty(); run = digits_from(stem, end_of(run, stem)))
        last = run;
    return std::string(last);
}

std::string longest_number(std::string_view stem) {
    std::string_view longest;
    for (std::size_t at = 0; at < stem.size();) {
        const std::string_view whole = digits_from(stem, at);
        at = end_of(whole, stem);
        if (whole.empty()) break;
        std::string_view number = whole;
        const std::string_view fraction = digits_from(stem, at);
        const bool has_fraction = !fraction.empty() && stem[at] == '.' &&
                                  end_of(fraction, stem) == at + 1 + fraction.size();
        if (has_fraction) {
            at = end_of(fraction, stem);
            number = stem.substr(at - fraction.size() - 1 - whole.size(),
                                 whole.size() + 1 + fraction.size());
        }
        if (number.size() > longest.size()) longest = number;
    }
    return std::string(longest);
}

}  // namespace divemesh::recording
