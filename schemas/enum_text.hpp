#pragma once

#include <span>
#include <stdexcept>
#include <string>
#include <string_view>

#include "schemas/error.hpp"

namespace divemesh {

// One row of the table that gives the words of an enum in JSON and SQL.
template <typename Enum>
struct EnumText {
    Enum value;
    std::string_view text;
};

template <typename Enum, std::size_t N>
constexpr std::string_view enum_to_text(const EnumText<Enum> (&table)[N], Enum value) {
    for (const auto& row : table)
        if (row.value == value) return row.text;
    throw std::logic_error("enum value without a text");
}

// Returns the value for a word. Throws Error{InvalidArgument}, which names `what` and lists the
// known words.
template <typename Enum>
Enum enum_from_text(std::span<const EnumText<Enum>> table,
                    std::string_view text,
                    std::string_view what) {
    std::string known;
    for (const auto& row : table) {
        if (row.text == text) return row.value;
        known += (known.empty() ? "" : ", ") + std::string(row.text);
    }
    throw Error(
        ErrorCode::InvalidArgument,
        "unknown " + std::string(what) + ": " + std::string(text) + " (known: " + known + ")");
}

}  // namespace divemesh
