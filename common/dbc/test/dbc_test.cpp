#include "common/dbc/dbc.hpp"

#include <gtest/gtest.h>

#include "common/config/section.hpp"
#include "common/test/source.hpp"

namespace roadbalance {
namespace {

// As an editor writes it, with every section that has to be passed over.
const std::string kWhole = R"(VERSION "1.0; BO_ \"x\""

NS_ :
	NS_DESC_
	CM_
	BA_DEF_
	VAL_
	SIG_VALTYPE_

BS_: 500000 : 1,2

BU_: Gateway Brake
VAL_TABLE_ Gears 0 "P" 1 "R" ;

BO_ 170 Wheels: 8 Brake
 SG_ Left : 7|16@0+ (0.01,-67.67) [0|250] "km/h" Gateway,Brake
 SG_ Right : 23|16@0- (.5,+1) [-1e2|1E+2] "°" Gateway

BO_ 2566844672 Long: 64 Vector__XXX
 SG_ Which M : 0|4@1+ (1,0) [0|15] "" Vector__XXX
 SG_ Steering m2 : 8|32@1- (1,0) [0|0] "deg" Vector__XXX
 SG_ Exact m11 : 448|64@1- (1,0) [0|0] "rad" Vector__XXX

BO_ 3221225472 VECTOR__INDEPENDENT_SIG_MSG: 0 Vector__XXX
 SG_ Unused : 0|8@1+ (1,0) [0|0] "" Vector__XXX

BO_ 2566869221 Transported: 39 Brake
BO_TX_BU_ 170 : Brake,Gateway;
EV_ Variable: 0 [0|10] "" 0 1 DUMMY_NODE_VECTOR0 Vector__XXX;
CM_ "a comment
BO_ 1 over: lines";
CM_ SG_ 170 Left "with ; in it";
BA_DEF_ BO_  "GenMsgCycleTime" INT 0 1000;
BA_DEF_DEF_  "GenMsgCycleTime" 10;
BA_ "GenMsgCycleTime" BO_ 170 12;
VAL_ 170 Left 65535 "not available" 65534 "fault" ;
VAL_ 3221225472 Unused 1 "one" ;
VAL_ Variable 0 "off" ;
SIG_VALTYPE_ 2566844672 Steering : 1;
SIG_VALTYPE_ 2566844672 Exact 2;
SIG_GROUP_ 170 Both 1 : Left Right;
)";

TEST(Dbc, ReadsEveryFeature) {
  const Dbc dbc = Dbc::parse(kWhole, "whole.dbc");
  ASSERT_EQ(dbc.messages.size(), 3U);
  const DbcMessage& wheels = dbc.messages[0];
  EXPECT_EQ(wheels.name, "Wheels");
  EXPECT_EQ(wheels.id, 170U);
  EXPECT_FALSE(wheels.extended);
  EXPECT_EQ(wheels.size, 8U);
  EXPECT_EQ(wheels.line, 15);
  ASSERT_EQ(wheels.signals.size(), 2U);
  const DbcSignal& left = wheels.signals[0];
  EXPECT_EQ(left.place.order, ByteOrder::kBigEndian);
  EXPECT_EQ(left.place.start_bit, 7);
  EXPECT_EQ(left.place.length, 16);
  EXPECT_EQ(left.place.number, CanNumber::kUnsigned);
  EXPECT_EQ(left.place.scale, 0.01);
  EXPECT_EQ(left.place.offset, -67.67);
  EXPECT_EQ(left.low, 0.0);
  EXPECT_EQ(left.high, 250.0);
  EXPECT_EQ(left.unit, "km/h");
  EXPECT_EQ(left.line, 16);
  ASSERT_EQ(left.codes.size(), 2U);
  EXPECT_EQ(left.codes[0].raw, 65'535.0);
  EXPECT_EQ(left.codes[0].meaning, "not available");
  const DbcSignal& right = wheels.signals[1];
  EXPECT_EQ(right.place.number, CanNumber::kSigned);
  EXPECT_EQ(right.place.scale, 0.5);
  EXPECT_EQ(right.place.offset, 1.0);
  EXPECT_EQ(right.low, -100.0);
  EXPECT_EQ(right.high, 100.0);

  const DbcMessage& longer = *dbc.message("Long");
  EXPECT_TRUE(longer.extended);
  EXPECT_EQ(longer.id, 2'566'844'672U - (1U << 31));
  EXPECT_EQ(longer.multiplexor()->name, "Which");
  EXPECT_EQ(longer.signal("Steering")->when_bits, 2U);
  EXPECT_EQ(longer.signal("Steering")->place.number, CanNumber::kFloat);
  EXPECT_EQ(longer.signal("Steering")->place.order, ByteOrder::kLittleEndian);
  EXPECT_EQ(longer.signal("Exact")->place.number, CanNumber::kDouble);
  EXPECT_EQ(longer.signal("nothing"), nullptr);
  EXPECT_EQ(dbc.message("Transported")->size, 39U);
  EXPECT_EQ(dbc.message("VECTOR__INDEPENDENT_SIG_MSG"), nullptr);
}

TEST(Dbc, ReadsTheSameWithWindowsLineEndsAndAByteOrderMark) {
  std::string text = "\xEF\xBB\xBF";
  for (const char c : kWhole) text += c == '\n' ? "\r\n" : std::string(1, c);
  const Dbc dbc = Dbc::parse(text, "whole.dbc");
  ASSERT_EQ(dbc.messages.size(), 3U);
  EXPECT_EQ(dbc.messages[0].signals[1].line, 17);
}

TEST(Dbc, ReadsAListOfWordsThatAreNotIndented) {
  const Dbc dbc = Dbc::parse("NS_ :\nCM_\nVAL_\nBS_:\nBU_:\nCM_ \"x\";\nBO_ 1 M: 8 X\n", "flat.dbc");
  EXPECT_EQ(dbc.messages.size(), 1U);
}

TEST(Dbc, IsEmptyWithoutMessages) {
  EXPECT_TRUE(Dbc::parse("", "empty.dbc").messages.empty());
  EXPECT_TRUE(Dbc::parse("VERSION \"\"\nBU_:\n", "empty.dbc").messages.empty());
}

std::string error_of(const std::string& text) {
  try {
    static_cast<void>(Dbc::parse(text, "bad.dbc"));
  } catch (const ConfigError& error) {
    return error.what();
  }
  return "no error";
}

const std::string kMessage = "BO_ 100 M: 8 X\n";

TEST(Dbc, SaysInWhichLineWhatWasExpected) {
  const std::pair<const char*, const char*> cases[] = {
      {"SG_ S", "bad.dbc:2: expected \":\", M or m and a number after the signal's name, found the end"},
      {"SG_ : 0|8", "bad.dbc:2: expected the signal's name, found \":\""},
      {"SG_ S : x|8", "bad.dbc:2: expected the start bit, 0 .. 14279, found \"x\""},
      {"SG_ S : 0,8", "bad.dbc:2: expected \"|\" between start bit and length, found \",\""},
      {"SG_ S : 0|65@1+", "bad.dbc:2: expected the length in bits, 1 .. 64, found \"65\""},
      {"SG_ S : 0|0@1+", "bad.dbc:2: expected the length in bits, 1 .. 64, found \"0\""},
      {"SG_ S : 0|8.5@1+", "bad.dbc:2: expected the length in bits, 1 .. 64, found \"8.5\""},
      {"SG_ S : 0|8@2+", "bad.dbc:2: expected the byte order, 0 Motorola or 1 Intel, 0 .. 1, found \"2\""},
      {"SG_ S : 0|8@1 (", "bad.dbc:2: expected \"+\" or \"-\", the signal's sign, found \"(\""},
      {"SG_ S : 60|8@1+ (", "bad.dbc:2: signal S does not fit into the 8 bytes of message M"},
      {"SG_ S : 56|9@0+ (", "bad.dbc:2: signal S does not fit into the 8 bytes of message M"},
      {"SG_ S : 0|8@1+ (0,0)", "bad.dbc:2: signal S: the scale is 0"},
      {"SG_ S : 0|8@1+ (1e999,0)", "bad.dbc:2: expected the scale, found \"1e999\""},
      {"SG_ S : 0|8@1+ (1,0) [5|4]", "bad.dbc:2: signal S: the range ends below its beginning"},
      {"SG_ S : 0|8@1+ (1,0)\n[0|4] km", "bad.dbc:3: expected the unit in quotes, found \"km\""},
      {"SG_ S : 0|8@1+ (1,0) [0|4] \"km", "bad.dbc:2: expected a closing \" before the end of the file"},
      {"SG_ S m0M : 0|8@1+", "bad.dbc:2: signal S: extended multiplexing (m0M) is not supported"},
      {"SG_ S mx : 0|8@1+", "bad.dbc:2: expected \":\", M or m and a number after the signal's name"},
      {"SG_MUL_VAL_ 100 a b 0-0;", "bad.dbc:2: extended multiplexing (SG_MUL_VAL_) is not supported"},
      {"SG_ S m1 : 0|8@1+ (1,0) [0|0] \"\" X",
       "bad.dbc:2: signal S is multiplexed, but message M has no multiplexor"},
      {"SG_ S M : 0|2@1+ (1,0) [0|0] \"\" X\nSG_ T m4 : 8|8@1+ (1,0) [0|0] \"\" X",
       "bad.dbc:3: signal T: its multiplexor S never has that value"},
      {"SG_ S M : 0|2@1+ (1,0) [0|0] \"\" X\nSG_ T M : 8|8@1+ (1,0) [0|0] \"\" X",
       "bad.dbc:3: message M has a second multiplexor, T"},
      {"SG_ S : 0|2@1+ (1,0) [0|0] \"\" X\nSG_ S : 8|8@1+ (1,0) [0|0] \"\" X",
       "bad.dbc:3: signal S is there already in message M"},
      {"BO_ 100 N: 8 X", "bad.dbc:2: message 100 is there already in line 1"},
      {"BO_ 101 M: 8 X", "bad.dbc:2: a message M is there already"},
      {"BO_ 2048 N: 8 X", "bad.dbc:2: message 2048: the identifier has more than 11 bits"},
      {"BO_ 4294967295 N: 8 X", "bad.dbc:2: message 4294967295: the identifier has more than 11 bits"},
      {"BO_ 4294967296 N: 8 X", "bad.dbc:2: expected the message's identifier, 0 .. 4294967295, found"},
      {"BO_ 1 N: 1786 X", "bad.dbc:2: expected the message's bytes, 0 .. 1785, found \"1786\""},
      {"BO_ 1 N 8 X", "bad.dbc:2: expected \":\" after the message's name, found \"8\""},
      {"VAL_ 99 S 0 \"x\";", "bad.dbc:2: there is no message 99"},
      {"VAL_ 100 S 0 \"x\";", "bad.dbc:2: message 100 has no signal S"},
      {"SIG_VALTYPE_ 100 S : 1;", "bad.dbc:2: message 100 has no signal S"},
      {"SG_ S : 0|8@1+ (1,0) [0|0] \"\" X\nSIG_VALTYPE_ 100 S : 1;",
       "bad.dbc:3: signal S has 8 bits, its kind of number 32"},
      {"SG_ S : 0|8@1+ (1,0) [0|0] \"\" X\nVAL_ 100 S 0 x;",
       "bad.dbc:3: expected the value's meaning in quotes"},
      {"SG_ S : 0|8@1+ (1,0) [0|0] \"\" X\nVAL_ 100 S 0 \"x\"", "bad.dbc:3: expected a value or \";\""},
      {"CM_ \"x\"\nBO_ 5 N: 8 X", "bad.dbc:3: expected \";\" after section CM_ of line 2, found \"BO_\""},
      {"CM_ \"x\"\n", "bad.dbc:3: expected \";\" after section CM_ of line 2, found the end of the file"},
      {"VERSION 1", "bad.dbc:2: expected the version in quotes, found \"1\""},
      {"; BO_", "bad.dbc:2: expected a section such as BO_, found \";\""},
      {"CM_ \"x\";\nSG_ S : 0|8@1+", "bad.dbc:3: SG_ stands outside of a message (BO_)"},
  };
  for (const auto& [text, expected] : cases) {
    const std::string error = error_of(kMessage + text);
    EXPECT_TRUE(error.starts_with(expected)) << text << "\n  says " << error;
  }
}

// The message would end at a zero, and an escape would act on a terminal.
TEST(Dbc, ShowsBytesThatAreNoTextByTheirNumbers) {
  EXPECT_EQ(error_of(std::string(1, '\0')), "bad.dbc:1: expected a section such as BO_, found \"\\x00\"");
  EXPECT_EQ(error_of("\x1B[2J"), "bad.dbc:1: expected a section such as BO_, found \"\\x1B\"");
  EXPECT_EQ(error_of("BO_ \"a\aN\x7F\""),
            "bad.dbc:1: expected the message's identifier, 0 .. 4294967295, found \"a\\x07N\\x7F\"");
}

TEST(Dbc, HasBounds) {
  std::string many;
  for (std::size_t k = 0; k <= Dbc::kMostMessages; ++k)
    many += "BO_ " + std::to_string((1LL << 31) + static_cast<std::int64_t>(k)) + " M" + std::to_string(k) +
            ": 8 X\n";
  EXPECT_EQ(error_of(many), "bad.dbc:10001: more than 10000 messages");
  std::string wide = kMessage;
  for (std::size_t k = 0; k <= Dbc::kMostSignals; ++k)
    wide += " SG_ S" + std::to_string(k) + " : 0|8@1+ (1,0) [0|0] \"\" X\n";
  EXPECT_EQ(error_of(wide), "bad.dbc:1002: message M has more than 1000 signals");
  EXPECT_EQ(error_of(std::string(Dbc::kMostBytes + 1, ' ')),
            "bad.dbc: a DBC file of 16777217 bytes; allowed: 16777216");
}

}  // namespace
}  // namespace roadbalance
