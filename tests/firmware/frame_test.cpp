// SPDX-License-Identifier: GPL-2.0-or-later
// Frames of the serial line: whole ones come through, garbage does not, and costs no more than what it destroyed.
#include "firmware/haptable_frame.h"

#include <gtest/gtest.h>

#include <cstring>
#include <random>
#include <vector>

namespace haptable::test {
namespace {

using Bytes = std::vector<std::uint8_t>;

Bytes state_frame(std::uint32_t sequence) {
    const haptable_frame_state state{
        sequence * 1000, {0.001F * static_cast<float>(sequence % 100), 0.02F, -0.03F}, sequence % 8};
    Bytes bytes(HAPTABLE_FRAME_BYTES);
    bytes.resize(haptable_frame_write_state(sequence, &state, bytes.data()));
    return bytes;
}

class FrameReaderTest : public testing::Test {
protected:
    FrameReaderTest() { haptable_frame_reader_init(&reader); }
    /// Sequence numbers of the frames in the bytes; each frame must be a state as it was sent.
    std::vector<std::uint32_t> read(const Bytes& bytes) {
        std::vector<std::uint32_t> sequences;
        for (std::uint8_t byte : bytes) {
            haptable_frame got{};
            if (haptable_frame_read(&reader, byte, &got) == 0) continue;
            const Bytes sent = state_frame(got.sequence);
            EXPECT_EQ(Bytes(got.payload, got.payload + got.length), Bytes(sent.begin() + 8, sent.end() - 4));
            sequences.push_back(got.sequence);
        }
        return sequences;
    }

    haptable_frame_reader reader;
};

// Byte for byte as documented, with the CRC that zlib's crc32 gives for these bytes.
TEST_F(FrameReaderTest, WritesTheDocumentedBytes) {
    const haptable_frame_state state{0x01020304, {1.0F, 0.0F, -2.0F}, HAPTABLE_BUTTON_GRAB};
    Bytes bytes(HAPTABLE_FRAME_BYTES);
    ASSERT_EQ(haptable_frame_write_state(7, &state, bytes.data()), 32U);
    const Bytes want{0xA5, 0x5A, 20, 1, 7, 0, 0, 0,    4, 3, 2, 1, 0,    0,    0x80, 0x3F,
                     0,    0,    0,  0, 0, 0, 0, 0xC0, 2, 0, 0, 0, 0x75, 0xEE, 0x16, 0x34};
    EXPECT_EQ(Bytes(bytes.begin(), bytes.begin() + 32), want);
}

TEST_F(FrameReaderTest, ReturnsAForceAsItWas) {
    haptable_output sent{}, got{};
    sent.state = HAPTABLE_CONTACT;
    for (int c = 0; c < 3; ++c) {
        sent.vertex[c] = static_cast<std::uint16_t>(0x1201 + c);
        sent.force_n[c] = 0.1F * static_cast<float>(c + 1);
        sent.god_object_m[c] = -0.3F * static_cast<float>(c + 1);
        sent.alpha[c] = 0.25F * static_cast<float>(c);
        for (int a = 0; a < 3; ++a) sent.nodal_force_n[c][a] = static_cast<float>(3 * c + a);
    }
    Bytes bytes(HAPTABLE_FRAME_BYTES);
    bytes.resize(haptable_frame_write_force(9, 0x0123456789abcdefULL, &sent, bytes.data()));
    haptable_frame whole{};
    int frames = 0;
    for (std::uint8_t byte : bytes) frames += haptable_frame_read(&reader, byte, &whole);
    std::uint64_t hash = 0;
    ASSERT_EQ(frames, 1);
    ASSERT_EQ(haptable_frame_take_force(&whole, &hash, &got), 1);
    EXPECT_EQ(hash, 0x0123456789abcdefULL);
    EXPECT_EQ(got.state, sent.state);
    EXPECT_EQ(std::memcmp(got.vertex, sent.vertex, sizeof sent.vertex), 0);
    EXPECT_EQ(std::memcmp(got.force_n, sent.force_n, sizeof sent.force_n), 0);
    EXPECT_EQ(std::memcmp(got.god_object_m, sent.god_object_m, sizeof sent.god_object_m), 0);
    EXPECT_EQ(std::memcmp(got.alpha, sent.alpha, sizeof sent.alpha), 0);
    EXPECT_EQ(std::memcmp(got.nodal_force_n, sent.nodal_force_n, sizeof sent.nodal_force_n), 0);
}

// A false begin right before a frame must not swallow it.
TEST_F(FrameReaderTest, FindsAFrameInsideAFalseOne) {
    Bytes bytes{0xA5, 0x5A, HAPTABLE_FRAME_PAYLOAD, 1, 0xA5, 0xA5, 0x5A};
    std::vector<std::uint32_t> want;
    for (std::uint32_t sequence = 0; sequence < 8; ++sequence) {
        const Bytes one = state_frame(sequence);
        bytes.insert(bytes.end(), one.begin(), one.end());
        want.push_back(sequence);
    }
    EXPECT_EQ(read(bytes), want);
    EXPECT_EQ(reader.skipped_bytes, 7U);
}

// Any one byte changed loses that frame alone.
TEST_F(FrameReaderTest, LosesOnlyTheDamagedFrame) {
    const std::size_t length = state_frame(0).size();
    for (std::size_t at = 0; at < length; ++at) {
        Bytes bytes;
        for (std::uint32_t sequence = 0; sequence < 6; ++sequence) {
            const Bytes one = state_frame(sequence);
            bytes.insert(bytes.end(), one.begin(), one.end());
        }
        bytes[length + at] ^= 0x10;
        haptable_frame_reader_init(&reader);
        EXPECT_EQ(read(bytes), (std::vector<std::uint32_t>{0, 2, 3, 4, 5})) << "byte " << at;
    }
}

// A million bytes of garbage, rich in false begins, between frames: no frame that was not sent, none lost that was
// whole.
TEST_F(FrameReaderTest, ResynchronisesAfterAMillionBytesOfGarbage) {
    std::mt19937 random(1);
    std::size_t garbage = 0;
    std::uint32_t sequence = 0, found = 0;
    while (garbage < 1'000'000) {
        Bytes bytes(random() % 200);
        for (std::uint8_t& byte : bytes) byte = random() % 4 == 0 ? (random() % 2 != 0 ? 0xA5 : 0x5A) : random() & 0xFF;
        garbage += bytes.size();
        // As many frames as a false begin can cover, and one more.
        for (int i = 0; i < 5; ++i) {
            const Bytes one = state_frame(++sequence);
            bytes.insert(bytes.end(), one.begin(), one.end());
        }
        for (std::uint32_t got : read(bytes)) {
            EXPECT_LE(got, sequence);
            EXPECT_GT(got, found);
            found = got;
        }
        ASSERT_EQ(found, sequence);
    }
    EXPECT_EQ(reader.frames, sequence);
    EXPECT_EQ(reader.skipped_bytes, garbage);
}

}  // namespace
}  // namespace haptable::test
