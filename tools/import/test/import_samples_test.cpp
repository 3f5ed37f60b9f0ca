#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <map>
#include <set>

#include "host/recording/formats/csv_text.hpp"
#include "host/recording/verify/verify.hpp"
#include "tools/import/test/import_fixture.hpp"

namespace roadbalance {
namespace {

TEST_F(ImportSamples, GivesEachChannelToItsNodeInItsUnit) {
  const auto vehicle = two_nodes();
  const ImportReport report = import_samples(
      {.samples = write("s.csv", samples(1010, uniform)), .pulses = {}, .folder = folder_ / "record"},
      vehicle);
  EXPECT_EQ(report.rows, 1010);
  EXPECT_NEAR(report.rate_hz, kRate_hz, 1e-6);
  EXPECT_TRUE(report.holes.empty());
  EXPECT_EQ(verify_record(folder_ / "record").verdict, Verdict::kComplete);
  std::array<std::int64_t, 2> seen{};
  for (const auto& block : blocks_of_record()) {
    if (block.kind != BlockKind::kScan) continue;
    const auto scan = decode_scan(block);
    const auto n = static_cast<std::size_t>(scan.header.node - 1);
    for (std::int64_t row = 0; row < scan.header.scans; ++row) {
      const auto i = scan.header.first_scan + row;
      const double unit = n == 0 ? 0.002 : 0.001 * 9.80665;
      EXPECT_NEAR(vehicle.node[n].channel[0].to_si(scan.counts[static_cast<std::size_t>(row)][0]),
                  unit * static_cast<double>(i % 1000),
                  50.0 / kFullScaleCounts);  // half a count and rounding
      EXPECT_NEAR(static_cast<double>(scan.row_time_ns(row)), 1e9 * uniform(static_cast<std::size_t>(i)),
                  2.0);
      ++seen[n];
    }
  }
  EXPECT_EQ(seen[0], 1010);
  EXPECT_EQ(seen[1], 1010);
}

TEST_F(ImportSamples, FindsTheUniformRateBehindBunchedStamps) {
  // Stamps as a serial port gives them: eight samples at once, late.
  const auto bunched = [](std::size_t i) { return uniform(i / 8 * 8 + 7); };
  const ImportReport report = import_samples(
      {.samples = write("s.csv", samples(4000, bunched)), .pulses = {}, .folder = folder_ / "record"},
      two_nodes());
  // A saw tooth of 8 samples tilts the line by (8^2 - 1) / rows^2.
  EXPECT_NEAR(report.rate_hz, kRate_hz, 1.2 * kRate_hz * 63.0 / (4000.0 * 4000.0));
  EXPECT_NEAR(report.stamp_rms_s, std::sqrt((64.0 - 1.0) / 12.0) / kRate_hz,
              1e-5);  // of 0 .. 7 about its mean
  EXPECT_NEAR(report.stamp_max_s, 3.5 / kRate_hz, 1e-4);
  EXPECT_TRUE(report.holes.empty());
}

TEST_F(ImportSamples, DeclaresAHoleAsAGapOfItsExactLength) {
  const auto holed = [](std::size_t i) { return uniform(i < 777 ? i : i + 900); };
  const ImportReport report = import_samples(
      {.samples = write("s.csv", samples(2000, holed)), .pulses = {}, .folder = folder_ / "record"},
      two_nodes());
  ASSERT_EQ(report.holes.size(), 1U);
  EXPECT_EQ(report.holes[0].samples, 900);
  EXPECT_NEAR(report.holes[0].after_s, uniform(776), 1e-6);
  int gaps = 0;
  for (const auto& block : blocks_of_record())
    if (block.kind == BlockKind::kGap) {
      ++gaps;
      EXPECT_EQ(decode_gap(block).cause, GapCause::kSourceGap);
      EXPECT_EQ(block.header.first_scan, 777);
      EXPECT_EQ(block.header.scans, 900);
    }
  EXPECT_EQ(gaps, 2);  // one a node
  EXPECT_EQ(verify_record(folder_ / "record").verdict, Verdict::kIncomplete);
}

TEST_F(ImportSamples, KeepsPulsesOnTheirLine) {
  const auto report = import_samples({.samples = write("s.csv", samples(100, uniform)),
                                      .pulses = write("p.csv",
                                                      "time_s,wheel,kind\n2.01,front_left,tooth\n"
                                                      "2.05,front_left,zero\n"
                                                      "2.06,front_left,tooth_backward\n"
                                                      "2.07,front_left,lost\n"),
                                      .folder = folder_ / "record"},
                                     two_nodes());
  EXPECT_TRUE(report.has_pulses);
  EXPECT_EQ(report.nodes[0].edges, 0);
  EXPECT_EQ(report.nodes[1].edges, 4);
  for (const auto& block : blocks_of_record()) {
    if (block.kind != BlockKind::kEdge) continue;
    const auto edges = decode_edge(block).unpack();
    ASSERT_EQ(edges.size(), 4U);
    EXPECT_EQ(edges[0].line, 1);
    EXPECT_EQ(to_ns(edges[1].time), 2'050'000'000);
    EXPECT_EQ(edges[1].kind, EdgeKind::kZeroMark);
    EXPECT_EQ(edges[2].kind, EdgeKind::kToothBackward);
    EXPECT_EQ(edges[3].kind, EdgeKind::kLost);
  }
}

// An edge block bears its first edge's time, which is before that of scans sealed ahead of it.
TEST_F(ImportSamples, KeepsEachNodesSequenceWhateverItsTimes) {
  std::string pulses = "time_s,wheel,kind\n";
  for (int i = 0; i < 400; ++i) pulses += std::to_string(2.001 + 0.005 * i) + ",front_left,tooth\n";
  import_samples({.samples = write("s.csv", samples(1'000, uniform)),
                  .pulses = write("p.csv", pulses),
                  .folder = folder_ / "record"},
                 two_nodes());
  std::map<int, std::int64_t> last;
  int edges = 0;
  for (const auto& block : blocks_of_record()) {
    if (block.kind == BlockKind::kMeta) continue;  // stands in the preamble too
    EXPECT_GT(block.header.sequence, last[block.header.node]);
    last[block.header.node] = block.header.sequence;
    edges += block.kind == BlockKind::kEdge;
  }
  EXPECT_GT(edges, 1);
}

TEST_F(ImportSamples, GivesAnotherEpochToOtherPulsesAndAnotherVehicle) {
  auto vehicle = two_nodes();
  const auto epoch = [&](const std::string& pulses, const std::string& name) {
    import_samples({.samples = write("s.csv", samples(100, uniform)),
                    .pulses = write("p.csv", "time_s,wheel,kind\n" + pulses),
                    .folder = folder_ / name},
                   vehicle);
    return verify_record(folder_ / name).epoch.at(0).epoch;
  };
  const auto first = epoch("2.01,front_left,tooth\n", "a");
  EXPECT_EQ(epoch("2.01,front_left,tooth\n", "b"), first);
  EXPECT_NE(epoch("2.02,front_left,tooth\n", "c"), first);
  vehicle.text = "# two other nodes";
  EXPECT_NE(epoch("2.01,front_left,tooth\n", "d"), first);
}

TEST_F(ImportSamples, TakesANameThatTwoNodesHaveOnlyWithItsNode) {
  VehicleConfig vehicle = two_nodes();
  for (NodeConfig& node : vehicle.node) node.channel[0].name = "up";
  // As it is exported; "second" is in g, "first" in m/s^2.
  const ImportReport report = import_samples(
      {.samples = write("s.csv", samples(1'000, uniform)), .folder = folder_ / "record"}, vehicle);
  EXPECT_EQ(report.channels.at(0).channel, "second_up");
  for (const SealedBlock& block : blocks_of_record()) {
    if (block.kind != BlockKind::kScan) continue;
    const auto n = static_cast<std::size_t>(block.header.node - 1);
    const double unit = n == 0 ? 0.002 : 0.001 * 9.80665;
    EXPECT_NEAR(vehicle.node[n].channel[0].to_si(decode_scan(block).counts[1][0]),
                unit * static_cast<double>((block.header.first_scan + 1) % 1000), 50.0 / kFullScaleCounts);
  }
  // Whose it is cannot be known.
  fs::remove_all(folder_ / "record");
  EXPECT_NE(
      error_of("time_s,up\ns,g\n2.000,1\n2.002,1\n2.004,1\n", vehicle).find("no column for channel first_up"),
      std::string::npos);
}

TEST_F(ImportSamples, RefusesWhatItDoesNotUnderstandAndNamesIt) {
  const auto v = two_nodes();
  const auto good = samples(50, uniform);
  const auto with = [&](const std::string& from, const std::string& to) {
    std::string text = good;
    text.replace(text.find(from), from.size(), to);
    return text;
  };
  EXPECT_NE(error_of(with("m/s^2", "mV"), v).find("s.csv: channel first_up: its unit is \"mV\""),
            std::string::npos);
  EXPECT_NE(error_of(with("first_up", "third_up"), v).find("no column for channel first_up"),
            std::string::npos);
  EXPECT_NE(error_of(with("2.004000,0.0020", "2.004000,x"), v).find("s.csv:5: second_up: \"x\" is no number"),
            std::string::npos);
  EXPECT_NE(error_of(with("2.004000,", "1.004000,"), v).find("s.csv:5: time_s: goes back"),
            std::string::npos);
  EXPECT_NE(error_of(with("time_s", "t"), v).find("s.csv:1: t:"), std::string::npos);
  EXPECT_NE(error_of(samples(500, [](std::size_t i) { return 1.02 * uniform(i); }), v).find("rate_hz is 500"),
            std::string::npos);
  EXPECT_NE(error_of(good, v, "time_s,wheel,kind\n2.0,rear_left,tooth\n").find("wheel rear_left"),
            std::string::npos);
  EXPECT_NE(error_of(good, v, "time_s,wheel,kind\n2.0,front_left,spoke\n").find("p.csv:2: kind: \"spoke\""),
            std::string::npos);
  auto fast = v;
  for (NodeConfig& node : fast.node) node.rate_hz = 1e5;
  const auto holed = [](std::size_t i) { return (i < 25 ? -2e9 : 1.9e9) + 1e-5 * static_cast<double>(i); };
  EXPECT_NE(error_of(samples(50, holed), fast).find("s.csv: time_s: more than 1e14 samples are missing"),
            std::string::npos);
  auto fewer = v;
  fewer.node.pop_back();
  EXPECT_NE(error_of(good, fewer).find("column second_up"), std::string::npos);
  EXPECT_FALSE(fs::exists(folder_ / "record"));
}

TEST_F(ImportSamples, TakesARealCarsUnevenRecordingAndReportsItsFaultySensor) {
  const auto vehicle = VehicleConfig::read_file(data("wobbletracker.toml").string());
  const auto report = import_samples(
      {.samples = data("wobbletracker.csv"), .pulses = {}, .folder = folder_ / "record"}, vehicle);
  // The rate of the whole run; ten seconds of stamps bunched by 70 ms give it to 1 %.
  EXPECT_NEAR(report.rate_hz, 117.35, 1.17);
  EXPECT_GT(report.stamp_rms_s, 0.01);
  EXPECT_LT(report.stamp_max_s, 0.12);
  EXPECT_TRUE(report.holes.empty());
  EXPECT_FALSE(report.has_pulses);
  std::set<std::string> suspicious;
  for (const auto& suspicion : report.suspicions) suspicious.insert(suspicion.channel);
  EXPECT_EQ(suspicious, (std::set<std::string>{"passenger_axle_x", "passenger_axle_y", "passenger_axle_z"}));
  EXPECT_EQ(verify_record(folder_ / "record").verdict, Verdict::kComplete);
}

TEST_F(ImportSamples, MarksThatASpreadsheetWouldComputeComeBack) {
  const std::vector<std::string> texts{"=1+1", "+49", "-5", "@home", "'=1", "''@", "'twas", "bump"};
  std::string marks = "time_s,number,text\n";
  for (std::size_t k = 0; k < texts.size(); ++k) {
    const std::string cell = protected_text(texts[k]);
    EXPECT_EQ(std::string("=+-@").find(cell[0]), std::string::npos) << cell;
    marks += "3.0," + std::to_string(k + 1) + ",\"" + cell + "\"\n";
  }
  const std::vector<ImportedMark> read = read_marks(write("m.csv", marks));
  ASSERT_EQ(read.size(), texts.size());
  for (std::size_t k = 0; k < texts.size(); ++k) EXPECT_EQ(read[k].text, texts[k]);
  EXPECT_EQ(protected_text("'twas"), "'twas");
  EXPECT_THROW(read_marks(write("h.csv", "time_s,number,text\n3.0,1,a\xE2\x80\xAE\n")), ConfigError);
}

TEST_F(ImportSamples, ZeroMarksThatNameNoToothGiveNoAngleAndAreNamed) {
  VehicleConfig vehicle = two_nodes();
  vehicle.wheel[0].encoder.pulses_per_turn = 24;
  const auto import = [&](const std::vector<double>& marks) {
    std::vector<std::pair<double, std::string>> edges;
    for (int turn = 0; turn < 60; ++turn) {
      for (int tooth = 0; tooth < 24; ++tooth)
        edges.emplace_back(2.0 + (turn + tooth / 24.0) / 12.0, "tooth");
      for (const double at : marks) edges.emplace_back(2.0 + (turn + at) / 12.0, "zero");
    }
    std::ranges::sort(edges);
    std::string pulses = "time_s,wheel,kind\n";
    for (const auto& [time_s, kind] : edges) pulses += std::to_string(time_s) + ",front_left," + kind + "\n";
    fs::remove_all(folder_ / "record");
    return import_samples({.samples = write("s.csv", samples(2500, uniform)),
                           .pulses = write("p.csv", pulses),
                           .folder = folder_ / "record"},
                          vehicle);
  };
  const auto with_angle = [&] {
    int blocks = 0;
    for (const SealedBlock& block : blocks_of_record())
      if (block.kind == BlockKind::kScan && block.header.node == 2 &&
          (decode_scan(block).quality & quality_no_reference(1)) == 0)
        ++blocks;
    return blocks;
  };
  const auto named = [](const ImportReport& report) {
    for (const auto& [channel, what] : report.suspicions)
      if (channel == "front_left") return what;
    return std::string();
  };
  EXPECT_EQ(named(import({0.015})), "");
  EXPECT_GT(with_angle(), 80);
  const ImportReport two = import({0.015, 0.6});
  EXPECT_EQ(with_angle(), 0);
  EXPECT_EQ(named(two).find("has no angle: 1"), 0U) << named(two);
  EXPECT_NE(named(two).find(" teeth lie between its zero marks, and its ring has 24"), std::string::npos);
}

}  // namespace
}  // namespace roadbalance
