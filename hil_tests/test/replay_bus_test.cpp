// A recording on the bus again: by rb replay and by LCM's own player, and what the analyser makes of it.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "common/bus/bus.hpp"
#include "common/bus/results.hpp"
#include "common/record/record_reader.hpp"
#include "common/record/segment.hpp"
#include "common/test/bus_url.hpp"
#include "common/test/temporary_directory.hpp"
#include "hil_tests/program.hpp"
#include "host/analysis/drives/identify_record.hpp"

namespace roadbalance {
namespace {

constexpr double kPatience_s = 120;

using Message = std::pair<std::string, std::vector<std::uint8_t>>;

class ReplayOnTheBus : public testing::Test {
 protected:
  void record(int seconds) {
    test::run("rb",
              {"demo", "--headless", "--json", "--seed", "4", "--drive-seconds", std::to_string(seconds),
               "--rate", "max", "--record", record_},
              kPatience_s);
    ASSERT_TRUE(std::filesystem::exists(record_));
  }

  /// All that can be read of the record.
  std::vector<Message> recorded() const {
    std::vector<Message> all;
    RecordReader reader(record_);
    reader.finish();
    while (const auto event = reader.next())
      all.emplace_back(event->channel, std::vector(event->data.begin(), event->data.end()));
    return all;
  }

  /// All that a listener hears while a program plays.
  std::vector<Message> heard_of(const std::string& program, const std::vector<std::string>& arguments,
                                const std::string& url, std::size_t expected, int code = 0) {
    Bus bus(url);
    std::vector<Message> heard;
    bus.subscribe("RB_.*", [&](std::string_view channel, std::span<const std::uint8_t> bytes) {
      heard.emplace_back(channel, std::vector(bytes.begin(), bytes.end()));
    });
    test::Program player(program, arguments);
    EXPECT_TRUE(test::wait_until(
        [&] {
          bus.handle(std::chrono::milliseconds(10));
          return heard.size() >= expected;
        },
        kPatience_s))
        << program << ": " << heard.size() << " of " << expected;
    EXPECT_EQ(player.exit_code(kPatience_s), code) << program;
    bus.handle(std::chrono::milliseconds(50));
    return heard;
  }

  const test::TemporaryDirectory folder_;
  const std::string record_ = folder_ / "record";
};

TEST_F(ReplayOnTheBus, IsTheRecordAndWhatLcmsOwnPlayerGivesThreeTimes) {
  record(6);
  const std::vector<Message> recorded = this->recorded();
  ASSERT_GT(recorded.size(), 1000U);
  ASSERT_EQ(segment_numbers(record_), std::vector<int>{1});
  for (int run = 0; run < 3; ++run) {
    const std::string url = test::bus_url();
    EXPECT_EQ(heard_of("rb", {"replay", record_, "--speed", "10", "--url", url}, url, recorded.size()),
              recorded);
  }
  const std::string url = test::bus_url();
  EXPECT_EQ(heard_of("lcm-logplayer", {"--lcm-url=" + url, segment_path(record_, 1)}, url, recorded.size()),
            recorded);
}

TEST_F(ReplayOnTheBus, IsRefusedWhereAnotherIsPlayed) {
  record(6);
  const std::string url = test::bus_url();
  test::Program first("rb", {"replay", record_, "--url", url});
  Bus bus(url);
  bool heard = false;
  bus.subscribe("RB_BLOCK_.*", [&](std::string_view, std::span<const std::uint8_t>) { heard = true; });
  ASSERT_TRUE(test::wait_until(
      [&] {
        bus.handle(std::chrono::milliseconds(10));
        return heard;
      },
      kPatience_s));
  EXPECT_EQ(test::run("rb", {"replay", record_, "--url", url}, kPatience_s), 4);
  EXPECT_EQ(first.exit_code(kPatience_s), 0);
  EXPECT_EQ(test::run("rb", {"replay", record_, "--speed", "fast", "--url", url}, kPatience_s), 2);
  EXPECT_EQ(test::run("rb", {"replay", folder_ / "none", "--url", url}, kPatience_s), 4);
}

TEST_F(ReplayOnTheBus, PlaysTheRestOfADamagedOneAndSaysSo) {
  record(6);
  const std::filesystem::path segment = std::filesystem::path(record_) / "seg-000001.lcm";
  {
    std::fstream file(segment, std::ios::in | std::ios::out | std::ios::binary);
    file.seekp(static_cast<std::streamoff>(std::filesystem::file_size(segment) / 2));
    file.write("damaged", 7);
  }
  const std::vector<Message> readable = recorded();
  const std::string url = test::bus_url();
  EXPECT_EQ(heard_of("rb", {"replay", record_, "--speed", "10", "--url", url}, url, readable.size(), 1),
            readable);
}

/// The analyser's last results for each wheel and for the suspension, in bytes as they were sent; and how
/// many levels it sent.
struct Said {
  std::map<int, std::vector<std::uint8_t>> balance;
  std::vector<std::uint8_t> identification;
  int levels = 0;
};

void listen(Bus& bus, Said& said) {
  bus.subscribe(kBalanceChannel, [&](std::string_view, std::span<const std::uint8_t> bytes) {
    if (const auto balance = decode_balance(bytes))
      said.balance[balance->wheel] = std::vector(bytes.begin(), bytes.end());
  });
  bus.subscribe(kIdentificationChannel, [&](std::string_view, std::span<const std::uint8_t> bytes) {
    said.identification = std::vector(bytes.begin(), bytes.end());
  });
  bus.subscribe(kLevelChannel, [&](std::string_view, std::span<const std::uint8_t>) { ++said.levels; });
}

/// Listens until a program has ended.
void listen_until(Bus& bus, test::Program& program, int expected = 0) {
  std::optional<int> code;
  EXPECT_TRUE(test::wait_until(
      [&] {
        bus.handle(std::chrono::milliseconds(5));
        return (code = program.exit_code(0.0)).has_value();
      },
      kPatience_s));
  EXPECT_EQ(code, expected);
  bus.handle(std::chrono::milliseconds(50));
}

Said analysed(const std::string& record) {
  const std::string url = test::bus_url();
  Bus bus(url);
  Said said;
  listen(bus, said);
  test::Program analyser("rb-analyser", {"--record", record, "--exit-at-end", "--url", url});
  test::Program player("rb", {"replay", record, "--speed", "20", "--url", url});
  listen_until(bus, analyser);
  return said;
}

std::string port_of(const std::string& url) {
  const auto port = url.substr(url.rfind(':') + 1);
  return port.substr(0, port.find('?'));
}

TEST_F(ReplayOnTheBus, TheAnalyserIdentifiesTheSameAsLiveBitForBitThreeTimes) {
  Said live;
  {
    const std::string url = test::bus_url();
    Bus bus(url);
    listen(bus, live);
    test::Program demo("rb", {"demo", "--headless", "--json", "--seed", "4", "--drive-seconds", "90",
                              "--rate", "20", "--bus-port", port_of(url), "--record", record_});
    listen_until(bus, demo);
  }
  ASSERT_EQ(live.balance.size(), static_cast<std::size_t>(kWheels));
  EXPECT_GT(decode_balance(live.balance[0])->unbalance_g, 0.0);
  for (int run = 0; run < 3; ++run) {
    const Said again = analysed(record_);
    EXPECT_EQ(again.balance, live.balance);
    EXPECT_EQ(again.identification, live.identification);
    EXPECT_GT(again.levels, 10) << "the live view goes by the replay";
  }
  const DriveEstimate offline = identify_record(record_).estimate;
  EXPECT_EQ(encode(offline.identification), live.identification);
  for (const auto& [wheel, bytes] : live.balance)
    EXPECT_EQ(encode(offline.balance[static_cast<std::size_t>(wheel)]), bytes);
}

/// Levels by node and instant, spectra by node, channel, part and instant, in bytes as they were sent.
using Told = std::map<std::vector<std::int64_t>, std::vector<std::uint8_t>>;
struct LiveTold {
  Told levels, spectra;
  std::map<int, std::int64_t> first_ns;  ///< of the first level of each node
};

void listen(Bus& bus, LiveTold& told) {
  bus.subscribe(kLevelChannel, [&](std::string_view, std::span<const std::uint8_t> bytes) {
    const auto level = decode_level(bytes);
    ASSERT_TRUE(level);
    told.first_ns.try_emplace(level->node, level->time_ns);
    told.levels[{level->node, level->time_ns}] = std::vector(bytes.begin(), bytes.end());
  });
  bus.subscribe(kSpectrumChannel, [&](std::string_view, std::span<const std::uint8_t> bytes) {
    const auto part = decode_spectrum(bytes);
    ASSERT_TRUE(part);
    told.spectra[{part->node, part->channel, part->part, part->time_ns}] =
        std::vector(bytes.begin(), bytes.end());
  });
}

bool holds(const Told& all, const Told& wanted) {
  return std::ranges::all_of(wanted, [&](const auto& one) { return all.contains(one.first); });
}

TEST_F(ReplayOnTheBus, LevelsAndSpectraAreThoseOfTheDriveItselfBitForBitThreeTimes) {
  constexpr int kDrive_s = 14;
  const std::string url = test::bus_url();
  LiveTold live;
  {
    Bus bus(url);
    listen(bus, live);
    test::Program demo("rb", {"demo", "--headless", "--json", "--drive-seconds", std::to_string(kDrive_s),
                              "--rate", "1", "--bus-port", port_of(url), "--record", record_});
    listen_until(bus, demo, 1);  // no wheel is known after so short a drive
  }
  // The live analyser joined a drive that was under way: its first level is of a part of a tenth of a second,
  // and until its history of ten seconds is full its spectra are of less than the replay's.
  std::erase_if(live.levels, [&](const auto& one) {
    return one.first[1] <= live.first_ns[static_cast<int>(one.first[0])];
  });
  std::erase_if(live.spectra, [&](const auto& one) {
    return one.first[3] < live.first_ns[static_cast<int>(one.first[0])] + 11'000'000'000;
  });
  EXPECT_GT(live.levels.size(), 2U * 100U);
  EXPECT_GT(live.spectra.size(), 2U * 12U);
  for (int run = 0; run < 3; ++run) {
    const std::string again_url = test::bus_url();
    Bus bus(again_url);
    LiveTold again;
    listen(bus, again);
    test::Program analyser("rb-analyser", {"--record", record_, "--url", again_url});
    test::Program player("rb", {"replay", record_, "--url", again_url});
    listen_until(bus, player);
    // Results of the last part played come a moment later.
    static_cast<void>(test::wait_until(
        [&] {
          bus.handle(std::chrono::milliseconds(5));
          return holds(again.levels, live.levels) && holds(again.spectra, live.spectra);
        },
        5.0));
    for (Told LiveTold::*const which : {&LiveTold::levels, &LiveTold::spectra})
      for (const auto& [when, bytes] : live.*which) {
        const auto found = (again.*which).find(when);
        ASSERT_NE(found, (again.*which).end()) << "node " << when[0] << " at " << when.back();
        ASSERT_EQ(found->second, bytes) << "node " << when[0] << " at " << when.back();
      }
  }
}

}  // namespace
}  // namespace roadbalance
