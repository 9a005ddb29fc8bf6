#pragma once

#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <string>
#include <system_error>
#include <type_traits>
#include <vector>

#include "schemas/error.hpp"

namespace divemesh::base {

// A writer of plain values and vectors in this machine's byte order: scratch files never leave the
// machine.
class BinaryWriter {
public:
    explicit BinaryWriter(std::filesystem::path file)
        : file_(std::move(file)),
          temporary_(file_.string() + ".part"),
          stream_(temporary_, std::ios::binary) {}

    template <typename T>
    void put(const T& value) {
        static_assert(std::is_trivially_copyable_v<T>);
        write(&value, sizeof value);
    }

    template <typename T>
    void put_vector(const std::vector<T>& values) {
        put(static_cast<std::uint64_t>(values.size()));
        write(values.data(), values.size() * sizeof(T));
    }

    void put_text(const std::string& text) {
        put(static_cast<std::uint64_t>(text.size()));
        write(text.data(), text.size());
    }

    // Writes the bytes of an Eigen fixed-size type: plain numbers, though not trivially copyable.
    template <typename T>
    void put_raw(const T& value) {
        write(&value, sizeof value);
    }

    // Renames the file to its final name, after all data have been written. Throws
    // Error{OutOfSpace} when writing failed.
    void commit() {
        stream_.close();
        std::error_code failure;
        if (stream_) std::filesystem::rename(temporary_, file_, failure);
        if (!stream_ || failure)
            throw Error(ErrorCode::OutOfSpace,
                        "cannot write " + file_.string() +
                            ": free space in the scratch folder or choose another one");
    }

private:
    void write(const void* data, std::size_t num_bytes) {
        stream_.write(static_cast<const char*>(data), static_cast<std::streamsize>(num_bytes));
    }

    std::filesystem::path file_;
    std::filesystem::path temporary_;
    std::ofstream stream_;
};

// A reader of what BinaryWriter wrote. ok() becomes false for good at the first read beyond the
// end. A vector is refused before its memory is allocated when the file is too short to hold it.
class BinaryReader {
public:
    explicit BinaryReader(const std::filesystem::path& file) : stream_(file, std::ios::binary) {
        std::error_code failure;
        const auto size = std::filesystem::file_size(file, failure);
        bytes_left_ = failure ? 0 : size;
        ok_ = !failure && stream_.good();
    }

    bool ok() const { return ok_; }
    bool at_end() const { return ok_ && bytes_left_ == 0; }

    template <typename T>
    T get() {
        T value{};
        read(&value, sizeof value);
        return value;
    }

    template <typename T>
    std::vector<T> get_vector() {
        const auto num_values = get<std::uint64_t>();
        if (!ok_ || num_values > bytes_left_ / sizeof(T)) {
            ok_ = false;
            return {};
        }
        std::vector<T> values(num_values);
        read(values.data(), values.size() * sizeof(T));
        return values;
    }

    std::string get_text() {
        const auto num_bytes = get<std::uint64_t>();
        if (!ok_ || num_bytes > bytes_left_) {
            ok_ = false;
            return {};
        }
        std::string text(num_bytes, '\0');
        read(text.data(), text.size());
        return text;
    }

private:
    void read(void* data, std::size_t num_bytes) {
        if (!ok_ || num_bytes > bytes_left_) {
            ok_ = false;
            return;
        }
        stream_.read(static_cast<char*>(data), static_cast<std::streamsize>(num_bytes));
        ok_ = stream_.good();
        bytes_left_ -= num_bytes;
    }

    std::ifstream stream_;
    std::uint64_t bytes_left_ = 0;
    bool ok_ = false;
};

}  // namespace divemesh::base
