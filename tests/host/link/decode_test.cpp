// SPDX-License-Identifier: GPL-2.0-or-later
// Messages whose bytes promise what they do not hold.
#include "host/link/decode.hpp"

#include <gtest/gtest.h>

#include <string>
#include <type_traits>
#include <vector>

#include "tests/loop/helpers.hpp"

namespace haptable::test {
namespace {

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

servo_status counted() {
    servo_status status{};
    status.count = 3;
    status.name = {"ticks_2", "late", ""};
    status.value = {1, -2, 3};
    return status;
}

servo_status named(const std::string& name) {
    servo_status status{};
    status.count = 1;
    status.name = {name};
    status.value = {1};
    return status;
}

tool_wrench felt() {
    tool_wrench wrench{};
    wrench.count = 2;
    wrench.touches = {1, 0};
    wrench.point_m = wrench.god_object_m = wrench.force_n = {{1.0, 2.0, 3.0}, {4.0, 5.0, 6.0}};
    return wrench;
}

// Room is made for no more than what is there: 2^31 - 1 nodes would take 60 GB.
TEST(Decode, NoCountIsBelieved) {
    for (const std::uint32_t count : {0x7FFFFFFFU, 0xFFFFFFFFU, 0x80000000U, 3U, 1U, 0U}) {
        std::vector<std::uint8_t> bomb = encoded(loaded());
        put_count(bomb, encoded(contact{}).size() - 4, count);
        contact load;
        EXPECT_FALSE(decode_whole(bomb, load)) << count;
        EXPECT_LE(load.node.capacity(), 2U);
    }
    const std::size_t names_at = encoded(servo_status{}).size() - 4;
    for (const std::uint32_t length : {0U, 4U, 6U, 0x7FFFFFFFU, 0x80000000U, 0x80000005U, 0xFFFFFFFFU}) {
        std::vector<std::uint8_t> bomb = encoded(named("name"));
        put_count(bomb, names_at + 4, length);
        servo_status said;
        EXPECT_FALSE(decode_whole(bomb, said)) << length;
        put_count(bomb, names_at, 0x7FFFFFFFU);
        EXPECT_FALSE(decode_whole(bomb, said));
        EXPECT_LE(said.name.capacity(), 1U);
    }
}

// What a terminal or gnuplot would act on is no name of a counter.
TEST(Decode, NamesAreNames) {
    servo_status out;
    for (const std::string name :
         {"\x1b[2Jticks", "ticks\n", "a`id`", "a\" with lines, \"", "a b", "\xc3\xa9", "a\x7f"})
        EXPECT_FALSE(decode_whole(encoded(named(name)), out)) << testing::PrintToString(name);
    std::vector<std::uint8_t> bytes = encoded(named("late"));
    bytes[encoded(servo_status{}).size() + 4 + 4] = 'r';  // no zero at its end
    EXPECT_FALSE(decode_whole(bytes, out));
}

template <typename Message>
class DecodeAll : public testing::Test {};
template <typename /*none*/, typename... Message>
struct TypesOf {
    using Types = testing::Types<Message...>;
};
#define HAPTABLE_TYPE(channel, type, ...) , type
using Messages = TypesOf<void HAPTABLE_MESSAGES(HAPTABLE_TYPE)>::Types;
#undef HAPTABLE_TYPE
TYPED_TEST_SUITE(DecodeAll, Messages);

/// Some entries where the type has any.
template <typename Message>
Message filled() {
    if constexpr (std::is_same_v<Message, contact>) return loaded();
    if constexpr (std::is_same_v<Message, servo_status>) return counted();
    if constexpr (std::is_same_v<Message, tool_wrench>) return felt();
    return {};
}

// A length may stand at any byte: wherever four bytes say one that is none, the message is refused or is that message.
TYPED_TEST(DecodeAll, NoLengthIsBelievedAnywhere) {
    const std::vector<std::uint8_t> whole = encoded(filled<TypeParam>());
    TypeParam out;
    ASSERT_TRUE(decode_whole(whole, out));
    EXPECT_EQ(encoded(out), whole);
    for (std::size_t at = kTypeHash_bytes; at + 4 <= whole.size(); ++at)
        for (const std::uint32_t length : {0U, 1U, 0x7FFFFFFFU, 0x80000000U, 0x80000001U, 0xFFFFFFFFU}) {
            std::vector<std::uint8_t> bomb = whole;
            put_count(bomb, at, length);
            TypeParam said;
            if (!decode_whole(bomb, said)) continue;
            EXPECT_EQ(encoded(said), bomb) << at;
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
