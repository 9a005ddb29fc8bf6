#include "schemas/token.hpp"

#include <algorithm>

namespace divemesh {

bool is_plain_word(std::string_view text) {
    constexpr std::size_t kMaxSizeBytes = 63;
    const auto letter_or_digit = [](char c) {
        return (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9');
    };
    return !text.empty() && text.size() <= kMaxSizeBytes && letter_or_digit(text.front()) &&
           std::all_of(text.begin(), text.end(), [&](char c) {
               return letter_or_digit(c) || c == '-' || c == '_';
           });
}

bool Token::allows(std::string_view scope) const {
    return !revoked && std::any_of(scopes.begin(), scopes.end(), [&](const std::string& held) {
        return held == scope || held == "admin";
    });
}

}  // namespace divemesh
