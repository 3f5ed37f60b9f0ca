#include "common/dbc/dbc_reading.hpp"

#include <array>
#include <cmath>
#include <limits>
#include <sstream>

#include <gtest/gtest.h>

#include "common/dbc/candump.hpp"
#include "common/test/source.hpp"

namespace roadbalance {
namespace {

using Status = DbcReading::Status;
const std::string kData = "common/dbc/test/data/";

CanFrame frame(const std::string& data) {
  return parse_candump("(1.000000) can0 064#" + data).value().frame;
}

DbcReading read(const std::string& signals, const std::string& data, const std::string& name = "S",
                const std::string& more = "") {
  const Dbc dbc = Dbc::parse("BO_ 100 M: 2 X\n" + signals + "\n" + more, "test.dbc");
  return read_signal(dbc.messages.at(0), *dbc.messages.at(0).signal(name), frame(data));
}

TEST(DbcReading, DecodesARealCarsWheelSpeedsAsPublished) {
  const Dbc dbc = Dbc::parse(test::read_source(kData + "rav4.dbc"), "rav4.dbc");
  const DbcMessage& message = *dbc.message("WHEEL_SPEEDS");
  std::istringstream log(test::read_source(kData + "rav4.candump.log"));
  std::istringstream table(test::read_source(kData + "rav4_wheel_speed.csv"));
  std::string line;
  std::getline(table, line);
  ASSERT_EQ(line, "time_s,front_left_m_s,front_right_m_s,rear_left_m_s,rear_right_m_s");
  int frames = 0;
  while (std::getline(log, line)) {
    const auto logged = parse_candump(line);
    ASSERT_TRUE(logged) << line;
    if (logged->frame.id != message.id) continue;
    ASSERT_TRUE(std::getline(table, line)) << "the table ends before the log";
    std::istringstream row(line);
    std::string cell;
    std::getline(row, cell, ',');
    EXPECT_EQ(logged->time_ns, std::llround(std::stod(cell) * 1e6) * 1'000);
    for (const char* name : {"WHEEL_SPEED_FL", "WHEEL_SPEED_FR", "WHEEL_SPEED_RL", "WHEEL_SPEED_RR"}) {
      const DbcReading speed_km_h = read_signal(message, *message.signal(name), logged->frame);
      std::getline(row, cell, ',');
      ASSERT_EQ(speed_km_h.status, Status::kOk);
      // The table has nine digits; one count is 2.8e-3 m/s.
      EXPECT_NEAR(speed_km_h.value / 3.6, std::stod(cell), 5.1e-8) << line;
    }
    ++frames;
  }
  EXPECT_FALSE(std::getline(table, line)) << "the log ends before the table";
  EXPECT_EQ(frames, 4974);
}

TEST(DbcReading, RefusesAFrameShorterThanItsMessageEvenIfTheSignalIsThere) {
  const std::string signal = " SG_ S : 7|8@0+ (1,0) [0|0] \"\" X";
  EXPECT_EQ(read(signal, "0102").value, 1.0);
  EXPECT_EQ(read(signal, "010203").status, Status::kOk);
  EXPECT_EQ(read(signal, "01").status, Status::kTooShort);
}

TEST(DbcReading, RefusesWhatLiesOutsideOfTheRange) {
  const std::string signal = " SG_ S : 7|16@0+ (0.01,0) [0|655.33] \"km/h\" X";
  EXPECT_EQ(read(signal, "0000").status, Status::kOk);
  EXPECT_EQ(read(signal, "FFFD").status, Status::kOk);  // 655.33, whichever way it is rounded
  EXPECT_EQ(read(signal, "FFFE").status, Status::kOutOfRange);
}

TEST(DbcReading, KnowsACodeFromAMeasurement) {
  const std::string codes = "VAL_ 100 S 65535 \"SNA\" 0 \"standing\" ;";
  const std::string ranged = " SG_ S : 7|16@0+ (0.01,0) [0|300] \"km/h\" X";
  EXPECT_EQ(read(ranged, "FFFF", "S", codes).status, Status::kNotAvailable);
  EXPECT_EQ(read(ranged, "FFFE", "S", codes).status, Status::kOutOfRange);
  EXPECT_EQ(read(ranged, "0000", "S", codes).status, Status::kOk);
  // Without a range a code of a quantity is no measurement, of a choice it is all there is.
  EXPECT_EQ(read(" SG_ S : 7|16@0+ (0.01,0) [0|0] \"km/h\" X", "FFFF", "S", codes).status,
            Status::kNotAvailable);
  EXPECT_EQ(read(" SG_ S : 7|16@0+ (1,0) [0|0] \"\" X", "FFFF", "S", codes).value, 65'535.0);
  // Codes are named as the frame has them, with their sign.
  EXPECT_EQ(read(" SG_ S : 7|8@0- (2,10) [0|200] \"deg\" X", "8000", "S", "VAL_ 100 S -128 \"SNA\" ;").status,
            Status::kNotAvailable);
}

TEST(DbcReading, FollowsTheMultiplexor) {
  const std::string signals =
      " SG_ Which M : 7|8@0+ (1,0) [0|0] \"\" X\n"
      " SG_ S m3 : 15|8@0+ (1,0) [0|0] \"\" X\n"
      " SG_ T m4 : 15|8@0+ (10,0) [0|0] \"\" X";
  EXPECT_EQ(read(signals, "0307").value, 7.0);
  EXPECT_EQ(read(signals, "0407").status, Status::kAbsent);
  EXPECT_EQ(read(signals, "0407", "T").value, 70.0);
  EXPECT_EQ(read(signals, "0507", "T").status, Status::kAbsent);
  EXPECT_EQ(read(signals, "0507", "Which").value, 5.0);
}

TEST(DbcReading, RefusesWhatIsNoNumber) {
  const Dbc dbc = Dbc::parse(
      "BO_ 100 M: 4 X\n SG_ S : 7|32@0+ (1,0) [0|0] \"\" X\n SG_ R : 7|32@0+ (1,0) [-5|5] \"\" X\n"
      "SIG_VALTYPE_ 100 S : 1;\nSIG_VALTYPE_ 100 R : 1;",
      "test.dbc");
  const DbcMessage& message = dbc.messages.at(0);
  for (const char* data : {"7FC00000", "7F800000", "FF800000"})
    for (const char* name : {"S", "R"})
      EXPECT_EQ(read_signal(message, *message.signal(name), frame(data)).status, Status::kOutOfRange);
  EXPECT_EQ(read_signal(message, *message.signal("R"), frame("C0200000")).value, -2.5);
}

}  // namespace
}  // namespace roadbalance
