#include "tools/rb/bus_distance.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdio>
#include <sstream>

#include "common/config/section.hpp"
#include "common/test/source.hpp"

namespace roadbalance {
namespace {

const std::string kData = "common/dbc/test/data/";

std::vector<LoggedFrame> rav4() {
  std::istringstream text(test::read_source(kData + "rav4.candump.log"));
  std::vector<LoggedFrame> log;
  for (std::string line; std::getline(text, line);) log.push_back(parse_candump(line).value());
  return log;
}
Dbc rav4_dbc() {
  return Dbc::parse(test::read_source(kData + "rav4.dbc"), "rav4.dbc");
}

/// Integral of the four published columns, front left, front right, rear left, rear right.
std::array<double, 4> published_distances() {
  std::istringstream table(test::read_source(kData + "rav4_wheel_speed.csv"));
  std::string line, cell;
  std::getline(table, line);
  std::array<double, 4> sum{}, before{};
  double before_s = 0.0;
  for (bool first = true; std::getline(table, line); first = false) {
    std::istringstream row(line);
    std::getline(row, cell, ',');
    const double time_s = std::stod(cell);
    for (std::size_t w = 0; w < 4; ++w) {
      std::getline(row, cell, ',');
      const double speed = std::stod(cell);
      if (!first) sum[w] += 0.5 * (speed + before[w]) * (time_s - before_s);
      before[w] = speed;
    }
    before_s = time_s;
  }
  return sum;
}

TEST(BusDistance, OfARealCarByItsCounterAndByItsSpeeds) {
  const BusDistance distance = bus_distance(rav4(), rav4_dbc(), "SPEED.ENCODER", std::nullopt);
  for (const std::string& line : distance_lines(distance)) std::printf("%s\n", line.c_str());
  const CounterDistance& counter = distance.counter;
  EXPECT_EQ(counter.messages, 2487);
  EXPECT_EQ(counter.counts, 20'900);
  EXPECT_EQ(counter.step, 4);
  EXPECT_EQ(counter.counters.wraps, (29 + 20'900) / 256);  // the first code is 29
  EXPECT_EQ(counter.runs, 1);
  EXPECT_EQ(counter.counters.invalid + counter.counters.out_of_order, 0);
  EXPECT_NEAR(counter.metres, 20'900 * 0.04905, 1e-9);

  const auto published = published_distances();
  ASSERT_EQ(distance.speed.size(), 5U);
  const std::array<std::size_t, 4> column{1, 0, 3, 2};  // as the DBC file has them
  for (std::size_t s = 0; s < 4; ++s) {
    EXPECT_EQ(distance.speed[s].messages, 4974);
    EXPECT_EQ(distance.speed[s].refused + distance.speed[s].silences, 0);
    EXPECT_NEAR(distance.speed[s].metres, published[column[s]], 1e-3) << distance.speed[s].signal;
  }
  EXPECT_EQ(distance.speed[0].signal, "WHEEL_SPEEDS.WHEEL_SPEED_FR");
  EXPECT_EQ(distance.speed[4].signal, "SPEED.SPEED");
  // The worth of one count was found from this very speed.
  EXPECT_NEAR(counter.metres, distance.speed[4].metres, 1.0);
  // The wheels say 2 % less than the speedometer's speed.
  EXPECT_NEAR(counter.metres - distance.speed[1].metres, 20.3, 0.5);
  EXPECT_EQ(distance_json(distance).at("angle"), nullptr);
}

TEST(BusDistance, CountsNothingAcrossAHoleInWhichTheCounterMayHaveWrapped) {
  std::vector<LoggedFrame> log = rav4();
  const std::int64_t start_ns = log.front().time_ns;
  // 2 s without any frame at 20 m/s: 800 counts of 256.
  std::erase_if(log, [&](const LoggedFrame& logged) {
    const double t = 1e-9 * static_cast<double>(logged.time_ns - start_ns);
    return t > 12.0 && t < 14.0;
  });
  const BusDistance distance = bus_distance(log, rav4_dbc(), "SPEED.ENCODER", std::nullopt);
  EXPECT_EQ(distance.counter.runs, 2);
  EXPECT_EQ(distance.counter.counters.ambiguous, 1);
  EXPECT_EQ(distance.speed[4].silences, 1);
  EXPECT_NEAR(distance.counter.seconds, distance.speed[4].seconds, 0.1);
  EXPECT_NEAR(distance.counter.metres, distance.speed[4].metres, 1.0);
}

TEST(BusDistance, TakesTheCodesOfTheDbcFileForNoCount) {
  const Dbc dbc = Dbc::parse(
      "BO_ 100 W: 2 X\n SG_ PULSES : 7|10@0+ (1,0) [0|1022] \"\" X\nVAL_ 100 PULSES 1023 \"invalid\" ;",
      "w.dbc");
  std::vector<LoggedFrame> log;
  for (int n = 0; n < 200; ++n) {
    const int code = n % 10 == 9 ? 1023 : (40 * n) % 1024;
    LoggedFrame logged{.time_ns = 20'000'000LL * n, .interface = "can0", .frame = {.id = 100, .size = 2}};
    ASSERT_TRUE(dbc.messages[0].signals[0].place.put_bits(static_cast<std::uint64_t>(code), logged.frame));
    log.push_back(logged);
  }
  const BusDistance distance = bus_distance(log, dbc, "W.PULSES", 0.02);
  EXPECT_EQ(distance.counter.counters.invalid, 20);
  EXPECT_EQ(distance.counter.counts, 40 * 198);
  EXPECT_EQ(distance.counter.runs, 1);
  EXPECT_TRUE(distance.speed.empty());
  EXPECT_THROW(bus_distance(log, dbc, "W.PULSES", std::nullopt), ConfigError) << "what is a count worth?";
}

TEST(BusDistance, NamesTheSignalAtFault) {
  for (const char* name : {"SPEED", "SPEED.NONE", "NONE.ENCODER", "WHEEL_SPEEDS.WHEEL_SPEED_FL"}) {
    try {
      bus_distance(rav4(), rav4_dbc(), name, std::nullopt);
      FAIL() << name;
    } catch (const ConfigError& error) {
      EXPECT_NE(std::string(error.what()).find(name), std::string::npos) << error.what();
    }
  }
}

}  // namespace
}  // namespace roadbalance
