// SPDX-License-Identifier: GPL-2.0-or-later
// Bytes on a serial line, written and read as frames.
#pragma once

#include <cstdint>
#include <vector>

#include "firmware/haptable_line_points.h"

namespace haptable::test {

using Bytes = std::vector<std::uint8_t>;

inline Bytes operator+(Bytes a, const Bytes& b) {
    a.insert(a.end(), b.begin(), b.end());
    return a;
}

/// Of who says this of itself, whether it is so or not.
inline Bytes frame_of(const haptable_line_hello& hello, std::uint32_t number = 0) {
    Bytes bytes(HAPTABLE_LINE_HELLO_BYTES);
    bytes.resize(haptable_line_write_hello(number, hello, bytes.data()));
    return bytes;
}
inline Bytes frame_of(const haptable_line_hello& hello, const haptable_line_state& state, std::uint32_t number) {
    Bytes bytes(HAPTABLE_LINE_STATE_BYTES);
    bytes.resize(haptable_line_write_state(number, &hello, state, bytes.data()));
    return bytes;
}
inline Bytes frame_of(const haptable_line_hello& hello, haptable_line_answer answer, std::uint32_t number) {
    Bytes bytes(HAPTABLE_LINE_ANSWER_BYTES);
    bytes.resize(haptable_line_write_answer(number, &hello, &answer, bytes.data()));
    return bytes;
}

/// A whole frame; its payload is a copy.
struct Heard {
    haptable_line_frame frame{};
    Bytes payload;
};

/// The receiving end, with room for frames of so many bytes.
class LineEar {
public:
    explicit LineEar(std::uint16_t most = HAPTABLE_TOOL_LINE_ANSWER_BYTES) : room_(most) {
        haptable_line_reader_init(room_.data(), most, &reader_);
    }
    LineEar(const LineEar&) = delete;
    LineEar& operator=(const LineEar&) = delete;

    std::vector<Heard> hear(const Bytes& bytes) {
        std::vector<Heard> all;
        for (const std::uint8_t byte : bytes) {
            Heard one;
            if (haptable_line_read(&reader_, byte, &one.frame) == 0) continue;
            one.payload.assign(one.frame.payload, one.frame.payload + one.frame.length);
            all.push_back(std::move(one));
        }
        for (Heard& one : all) one.frame.payload = one.payload.data();
        return all;
    }
    const haptable_line_reader& reader() const { return reader_; }

private:
    Bytes room_;
    haptable_line_reader reader_{};
};

}  // namespace haptable::test
