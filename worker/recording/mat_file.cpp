#include "worker/recording/mat_file.hpp"

#include <array>
#include <cmath>
#include <cstdint>
#include <libdeflate.h>
#include <memory>
#include <new>
#include <optional>

#include "schemas/error.hpp"
#include "worker/recording/byte_cursor.hpp"

namespace divemesh::recording {
namespace {

constexpr std::string_view kVersion5 = "MATLAB 5.0 MAT-file";
constexpr std::string_view kVersion73 = "MATLAB 7.3 MAT-file";
constexpr std::size_t kHeader_bytes = 128;
constexpr std::size_t kMaxNumbers = 4096;  // a matrix of a camera has 9
constexpr std::size_t kMaxText_bytes = 256;
constexpr int kMaxDepth = 8;  // of structs in each other
constexpr int kMaxValues = 20'000;
// Limits what a variable is inflated to, and all of them together. A larger one holds images.
constexpr std::size_t kMaxVariable_bytes = std::size_t{4} << 20U;
constexpr std::size_t kMaxInflated_bytes = std::size_t{64} << 20U;

// Types of elements.
constexpr std::uint32_t kUtf8 = 16;
constexpr std::uint32_t kMatrix = 14;
constexpr std::uint32_t kCompressed = 15;
// Classes of matrices; those from kDouble on are numbers.
constexpr std::uint32_t kStruct = 2;
constexpr std::uint32_t kObject = 3;
constexpr std::uint32_t kChar = 4;
constexpr std::uint32_t kDouble = 6;
constexpr std::uint32_t kUint64 = 15;
constexpr std::uint32_t kOpaque = 17;
constexpr std::uint32_t kComplexFlag = 0x800;

[[noreturn]] void fail(const std::string& why) { throw Error(ErrorCode::BadData, why); }

struct Element {
    std::uint32_t type = 0;
    std::string_view value;
};

// Takes an element from the front. One of up to four bytes has its size beside its type.
Element take_element(ByteCursor& bytes) {
    constexpr std::uint32_t kSmall_bytes = 4;
    constexpr std::size_t kFilled_bytes = 8;
    const auto type = bytes.take<std::uint32_t>();
    if (!type) fail("it is cut");
    if (const std::uint32_t size = *type >> 16U; size != 0) {
        const auto filled = bytes.take_bytes(kSmall_bytes);
        if (!filled || size > kSmall_bytes) fail("an element contradicts its size");
        return {*type & 0xFFFFU, filled->substr(0, size)};
    }
    const auto size = bytes.take<std::uint32_t>();
    const auto value = size ? bytes.take_bytes(*size) : std::nullopt;
    if (!value) fail("an element is longer than what holds it");
    if (*type != kCompressed && *size % kFilled_bytes != 0)
        bytes.take_bytes(kFilled_bytes - *size % kFilled_bytes);
    return {*type, *value};
}

template <typename Number>
void add_numbers(std::string_view value, std::vector<double>& numbers) {
    ByteCursor bytes(value);
    while (const auto number = bytes.take<Number>())
        numbers.push_back(static_cast<double>(*number));
}

// Returns the numbers of an element, whatever type they are stored as; {} for none of numbers.
std::vector<double> numbers_of(const Element& element) {
    std::vector<double> numbers;
    // clang-format off
    switch (element.type) {
        case 1: add_numbers<std::int8_t>(element.value, numbers); break;
        case 2: add_numbers<std::uint8_t>(element.value, numbers); break;
        case 3: add_numbers<std::int16_t>(element.value, numbers); break;
        case 4: add_numbers<std::uint16_t>(element.value, numbers); break;
        case 5: add_numbers<std::int32_t>(element.value, numbers); break;
        case 6: add_numbers<std::uint32_t>(element.value, numbers); break;
        case 7: add_numbers<float>(element.value, numbers); break;
        case 9: add_numbers<double>(element.value, numbers); break;
        case 12: add_numbers<std::int64_t>(element.value, numbers); break;
        case 13: add_numbers<std::uint64_t>(element.value, numbers); break;
        default: break;
    }
    // clang-format on
    return numbers;
}

// Returns a text, of which letters beyond ASCII are '?'.
std::string text_of(const Element& element) {
    if (element.type == kUtf8) return std::string(element.value.substr(0, kMaxText_bytes));
    std::string text;
    for (const double letter : numbers_of({element.type, element.value.substr(0, kMaxText_bytes)}))
        text += letter >= ' ' && letter <= '~' ? static_cast<char>(letter) : '?';
    return text;
}

// What every matrix begins with.
struct MatrixHead {
    std::uint32_t class_of = 0;
    bool is_complex = false;
    std::size_t num_rows = 0;
    std::size_t num_numbers = 0;  // more than kMaxNumbers: at least so many
    std::string name;
};

MatrixHead take_head(ByteCursor& bytes) {
    constexpr std::size_t kMaxDimensions = 32;
    MatrixHead head;
    ByteCursor flags(take_element(bytes).value);
    const auto word = flags.take<std::uint32_t>();
    if (!word) fail("a matrix lacks its class");
    head.class_of = *word & 0xFFU;
    head.is_complex = (*word & kComplexFlag) != 0;
    if (head.class_of != kOpaque) {  // which has no size
        ByteCursor sizes(take_element(bytes).value);
        head.num_numbers = 1;
        for (std::size_t i = 0; const auto size = sizes.take<std::int32_t>(); ++i) {
            if (*size < 0 || i == kMaxDimensions) fail("a matrix states no size that can be");
            if (i == 0) head.num_rows = static_cast<std::size_t>(*size);
            if (head.num_numbers <= kMaxNumbers)
                head.num_numbers *= static_cast<std::size_t>(*size);
        }
    }
    head.name = take_element(bytes).value.substr(0, kMaxText_bytes);
    return head;
}

class MatParser {
public:
    // Adds the variables of a file, or those of one element that was compressed.
    void add_variables(std::string_view elements, MatValue& root) {
        for (ByteCursor bytes(elements); !bytes.at_end();) {
            const Element element = take_element(bytes);
            if (element.type == kMatrix) add_variable(element.value, root);
            if (element.type != kCompressed) continue;
            const std::string inflated_bytes = inflated(element.value);
            ByteCursor inner(inflated_bytes);
            if (inner.at_end()) continue;
            const Element matrix = take_element(inner);
            if (matrix.type == kMatrix) add_variable(matrix.value, root);
        }
    }

private:
    void add_variable(std::string_view matrix, MatValue& root) {
        auto [name, value] = parse_matrix(matrix, 0);
        if (!name.empty()) root.fields.try_emplace(std::move(name), std::move(value));
    }

    // Returns the name and the value of a matrix.
    std::pair<std::string, MatValue> parse_matrix(std::string_view matrix, int depth) {
        if (++num_values_ > kMaxValues || depth > kMaxDepth)
            fail("it holds more than any calibration");
        MatValue value;
        if (matrix.empty()) return {"", value};  // an empty field
        ByteCursor bytes(matrix);
        const MatrixHead head = take_head(bytes);
        value.is_object = head.class_of == kObject || head.class_of == kOpaque;
        if (head.class_of == kStruct && head.num_numbers == 1)
            add_fields(bytes, depth, value);
        else if (head.class_of == kChar && head.num_numbers <= kMaxText_bytes)
            value.text = text_of(take_element(bytes));
        else if (head.class_of >= kDouble && head.class_of <= kUint64 && !head.is_complex &&
                 head.num_numbers <= kMaxNumbers)
            add_matrix(bytes, head, value);
        return {head.name, std::move(value)};
    }

    static void add_matrix(ByteCursor& bytes, const MatrixHead& head, MatValue& value) {
        value.num_rows = head.num_rows;
        if (head.num_numbers == 0) return;
        const Element element = take_element(bytes);
        constexpr std::size_t kMaxNumber_bytes = 8;
        if (element.value.size() > kMaxNumbers * kMaxNumber_bytes)
            fail("a matrix has more numbers than its size states");
        value.numbers = numbers_of(element);
        if (value.numbers.size() != head.num_numbers)
            fail("the matrix " + head.name + " has " + std::to_string(value.numbers.size()) +
                 " numbers, its size states " + std::to_string(head.num_numbers));
    }

    void add_fields(ByteCursor& bytes, int depth, MatValue& value) {
        ByteCursor length(take_element(bytes).value);
        const auto name_bytes = length.take<std::int32_t>();
        if (!name_bytes || *name_bytes <= 0) fail("a struct states no length of its names");
        const auto step = static_cast<std::size_t>(*name_bytes);
        const std::string_view names = take_element(bytes).value;
        for (std::size_t at = 0; at + step <= names.size(); at += step) {
            const Element element = take_element(bytes);
            if (element.type != kMatrix) fail("a field of a struct is no matrix");
            std::string_view name = names.substr(at, step);
            name = name.substr(0, name.find('\0'));
            value.fields.try_emplace(std::string(name),
                                     parse_matrix(element.value, depth + 1).second);
        }
    }

    // Returns what zlib packed; empty if it is larger than any calibration's.
    std::string inflated(std::string_view packed) {
        constexpr std::size_t kFirst_bytes = std::size_t{64} << 10U;
        for (std::size_t size = kFirst_bytes; size <= kMaxVariable_bytes; size *= 8) {
            num_inflated_bytes_ += size;
            if (num_inflated_bytes_ > kMaxInflated_bytes)
                fail("its variables are larger than any calibration's");
            std::string bytes(size, '\0');
            std::size_t num_bytes = 0;
            const auto result = libdeflate_zlib_decompress(decompressor_.get(),
                                                           packed.data(),
                                                           packed.size(),
                                                           bytes.data(),
                                                           bytes.size(),
                                                           &num_bytes);
            if (result == LIBDEFLATE_INSUFFICIENT_SPACE) continue;
            if (result != LIBDEFLATE_SUCCESS) fail("a variable does not decompress");
            bytes.resize(num_bytes);
            return bytes;
        }
        return {};
    }

    struct FreeDecompressor {
        void operator()(libdeflate_decompressor* decompressor) const {
            libdeflate_free_decompressor(decompressor);
        }
    };
    static libdeflate_decompressor* new_decompressor() {
        libdeflate_decompressor* decompressor = libdeflate_alloc_decompressor();
        if (decompressor == nullptr) throw std::bad_alloc();
        return decompressor;
    }

    std::unique_ptr<libdeflate_decompressor, FreeDecompressor> decompressor_{new_decompressor()};
    std::size_t num_inflated_bytes_ = 0;
    int num_values_ = 0;
};

}  // namespace

const MatValue& MatValue::at(const std::string& name) const {
    static const MatValue kNone;
    const auto found = fields.find(name);
    return found == fields.end() ? kNone : found->second;
}

bool is_mat(std::string_view bytes) {
    return bytes.starts_with(kVersion5) || bytes.starts_with(kVersion73);
}

MatValue parse_mat(std::string_view bytes, const std::string& file) {
    if (bytes.starts_with(kVersion73))
        fail(file +
             " is a MAT-file of version 7.3, which is not read: save it by save(..., '-v7')");
    if (bytes.size() < kHeader_bytes) fail(file + " is cut: save it again");
    if (bytes.substr(kHeader_bytes - 2, 2) != "IM")
        fail(file + " is of a computer with the other order of bytes: save it again on this one");
    MatValue root;
    try {
        MatParser().add_variables(bytes.substr(kHeader_bytes), root);
    } catch (const Error& error) {
        throw Error(error.code(), file + " is damaged: " + error.what() + ": save it again");
    }
    return root;
}

}  // namespace divemesh::recording
