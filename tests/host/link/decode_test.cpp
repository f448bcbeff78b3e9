// SPDX-License-Identifier: GPL-2.0-or-later
// Messages whose bytes promise what they do not hold.
#include "host/link/decode.hpp"

#include <gtest/gtest.h>

#include <vector>

namespace haptable::test {
namespace {

template <typename Message>
std::vector<std::uint8_t> encoded(const Message& message) {
    std::vector<std::uint8_t> bytes(static_cast<std::size_t>(message.getEncodedSize()));
    message.encode(bytes.data(), 0, static_cast<int>(bytes.size()));
    return bytes;
}

void put_count(std::vector<std::uint8_t>& bytes, std::size_t at, std::uint32_t count) {
    for (std::size_t b = 0; b < 4; ++b) bytes[at + b] = static_cast<std::uint8_t>(count >> (24 - 8 * b));
}

contact loaded() {
    contact message{};
    message.seq = 5;
    message.count = 2;
    message.node = {3, 4};
    message.force_n = {{1.0, 2.0, 3.0}, {4.0, 5.0, 6.0}};
    return message;
}

TEST(Decode, TakesWholeMessages) {
    contact out;
    ASSERT_TRUE(decode_whole(encoded(loaded()), out));
    EXPECT_EQ(out.seq, 5);
    EXPECT_EQ(out.node, (std::vector<std::int32_t>{3, 4}));
    EXPECT_EQ(out.force_n[1], (std::vector<double>{4.0, 5.0, 6.0}));
    servo_status status{};
    status.count = 2;
    status.name = {"", "two"};
    status.value = {1, 2};
    servo_status said;
    ASSERT_TRUE(decode_whole(encoded(status), said));
    EXPECT_EQ(said.name, status.name);
    EXPECT_EQ(said.value, status.value);
}

// Room is made for no more than what is there: 2^31 - 1 nodes would take 60 GB.
TEST(Decode, NoCountIsBelieved) {
    const std::vector<std::uint8_t> whole = encoded(loaded());
    const std::size_t count_at = encoded(contact{}).size() - 4;
    for (const std::uint32_t count : {0x7FFFFFFFU, 0xFFFFFFFFU, 0x80000000U, 3U, 1U, 0U}) {
        std::vector<std::uint8_t> bomb = whole;
        put_count(bomb, count_at, count);
        contact out;
        EXPECT_FALSE(decode_whole(bomb, out)) << count;
        EXPECT_LE(out.node.capacity(), 2U);
    }
    const std::size_t name_at = encoded(servo_status{}).size();
    servo_status status{};
    status.count = 1;
    status.name = {"name"};
    status.value = {1};
    for (const std::uint32_t length : {0U, 0x7FFFFFFFU, 0xFFFFFFFFU}) {
        std::vector<std::uint8_t> bomb = encoded(status);
        put_count(bomb, name_at, length);
        servo_status out;
        EXPECT_FALSE(decode_whole(bomb, out)) << length;
        put_count(bomb, name_at - 4, 0x7FFFFFFFU);
        EXPECT_FALSE(decode_whole(bomb, out));
        EXPECT_LE(out.name.capacity(), 1U);
    }
}

TEST(Decode, TakesNoPartsAndNoMore) {
    std::vector<std::uint8_t> bytes = encoded(loaded());
    contact out;
    for (std::size_t size = 0; size < bytes.size(); ++size)
        EXPECT_FALSE(decode_whole(std::span(bytes.data(), size), out)) << size;
    bytes.push_back(0);
    EXPECT_FALSE(decode_whole(bytes, out));
    device_state state;
    EXPECT_FALSE(decode_whole(encoded(servo_force{}), state)) << "of another type";
}

}  // namespace
}  // namespace haptable::test
