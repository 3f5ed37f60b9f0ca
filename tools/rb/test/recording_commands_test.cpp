// Somebody else's measurement through the documented commands: import, verify, levels, spectrum, identify.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <vector>

#include "common/test/source.hpp"
#include "common/test/temporary_directory.hpp"
#include "tools/rb/test/run_rb.hpp"

namespace roadbalance {
namespace {

using Json = nlohmann::json;

class RecordingCommands : public testing::Test {
 protected:
  test::Outcome rb(const std::vector<std::string>& arguments) {
    return test::run_rb(arguments, folder_ / "rb.log");
  }
  test::Outcome import(const std::string& samples, const std::string& into) {
    return rb({"import", "csv", "--samples", samples, "--vehicle",
               test::source_path("tools/rb/test/data/wobbletracker.toml"), "-o", into});
  }

  const test::TemporaryDirectory folder_;
  const std::string record_ = folder_ / "record";
};

const std::string kWobble = test::source_path("tools/rb/test/data/wobbletracker.csv");

/// Mean and rms about it of one column, from the text of the file alone.
std::pair<double, double> mean_and_rms(const std::string& column) {
  std::ifstream file(kWobble);
  std::string line, cell;
  std::getline(file, line);
  std::istringstream header(line);
  std::size_t index = 0, found = 0;
  for (; std::getline(header, cell, ','); ++index)
    if (cell == column) found = index;
  std::getline(file, line);  // units
  std::vector<double> values;
  while (std::getline(file, line)) {
    std::istringstream row(line);
    for (std::size_t i = 0; i <= found; ++i) std::getline(row, cell, ',');
    values.push_back(std::stod(cell));
  }
  double mean = 0.0, square = 0.0;
  for (const double v : values) mean += v / static_cast<double>(values.size());
  for (const double v : values) square += (v - mean) * (v - mean) / static_cast<double>(values.size());
  return {mean, std::sqrt(square)};
}

/// Slope of the least-squares line of row number over time stamp.
double rate_of_stamps() {
  std::ifstream file(kWobble);
  std::string line;
  std::getline(file, line);
  std::getline(file, line);
  std::vector<double> t;
  while (std::getline(file, line)) t.push_back(std::stod(line));
  const auto n = static_cast<double>(t.size());
  double t_mean = 0.0, index_index = 0.0, index_t = 0.0;
  for (const double stamp : t) t_mean += stamp / n;
  for (std::size_t k = 0; k < t.size(); ++k) {
    const double index = static_cast<double>(k) - (n - 1.0) / 2.0;
    index_index += index * index;
    index_t += index * (t[k] - t_mean);
  }
  return index_index / index_t;
}

TEST_F(RecordingCommands, ARealCarsMeasurementGoesAllTheWay) {
  const test::Outcome imported = import(kWobble, record_);
  ASSERT_EQ(imported.code, 0) << imported.log;
  EXPECT_NE(imported.log.find("from an even clock"), std::string::npos) << "uneven stamps are said";
  EXPECT_NE(imported.log.find("passenger_axle_z"), std::string::npos) << "the faulty sensor is named";

  EXPECT_EQ(rb({"verify", record_}).code, 0);

  const Json levels = Json::parse(rb({"levels", record_, "--json"}).output);
  ASSERT_EQ(levels["channels"].size(), 12U);
  for (const Json& channel : levels["channels"]) {
    const auto [mean, rms] = mean_and_rms(channel["channel"]);
    // A count of the 16 g range is 2e-5 m/s^2.
    EXPECT_NEAR(channel["mean"], mean, 2e-5) << channel;
    EXPECT_NEAR(channel["rms"], rms, 2e-5) << channel;
  }

  const Json spectrum =
      Json::parse(rb({"spectrum", record_, "--channel", "driver_knuckle_z", "--json"}).output);
  EXPECT_GE(spectrum["averages"], 1);
  EXPECT_EQ(spectrum["unit"], "(m/s^2)^2/Hz");

  // Frequencies are those of the rate at which the samples really came, not of the nominal 117 Hz.
  const auto& frequency = spectrum["frequency_hz"];
  const double rate_hz = spectrum["step_hz"].get<double>() * std::round(4.0 * rate_of_stamps());
  EXPECT_NEAR(rate_hz, rate_of_stamps(), 1e-4 * rate_of_stamps());
  EXPECT_NEAR(frequency.back(), rate_hz / 2, spectrum["step_hz"]);

  const test::Outcome identified = rb({"identify", record_, "--json"});
  EXPECT_EQ(identified.code, 1) << "the answer is no";
  EXPECT_TRUE(Json::parse(identified.output)["wheels"][0]["unbalance_g"].is_null());
  EXPECT_NE(identified.log.find("identification_rate_hz"), std::string::npos) << identified.log;
}

TEST_F(RecordingCommands, SpectrumIsMadeAsItIsAskedFor) {
  ASSERT_EQ(import(kWobble, record_).code, 0);
  const auto spectrum = [&](const std::vector<std::string>& more) {
    std::vector<std::string> arguments{"spectrum", record_, "--channel", "driver_knuckle_z",
                                       "--block",  "256",   "--json"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    const test::Outcome told = rb(arguments);
    EXPECT_EQ(told.code, 0) << told.log;
    return Json::parse(told.output);
  };
  const Json density = spectrum({});
  EXPECT_EQ(density["density"].size(), 129U);
  const double enbw_hz = density["enbw_hz"];
  EXPECT_NEAR(enbw_hz, 1.5 * density["step_hz"].get<double>(), 1e-9) << "Hann";
  const Json rms = spectrum({"--show", "rms"}), peak = spectrum({"--show", "peak"});
  const Json held = spectrum({"--average", "peak-hold"});
  const Json exponential = spectrum({"--average", "exponential", "--memory", "1"});
  EXPECT_EQ(peak["unit"], "m/s^2 peak");
  bool differs = false;
  for (std::size_t k = 0; k < 129; ++k) {
    const double g = density["density"][k];
    EXPECT_NEAR(rms["amplitude"][k], std::sqrt(g * enbw_hz), 1e-12);
    const bool is_sine = k != 0 && k != 128;  // 0 Hz and half the rate are no sine
    EXPECT_NEAR(peak["amplitude"][k], std::sqrt((is_sine ? 2.0 : 1.0) * g * enbw_hz), 1e-12);
    EXPECT_GE(held["density"][k].get<double>(), g * (1.0 - 1e-12)) << "no mean is above its greatest";
    EXPECT_LE(exponential["density"][k].get<double>(), held["density"][k].get<double>() * (1.0 + 1e-12));
    differs = differs || exponential["density"][k] != density["density"][k];
  }
  EXPECT_TRUE(differs) << "the last segment is not the mean of all";
  // HFT95's equivalent noise bandwidth is 3.8112 bins.
  const Json flat = spectrum({"--window", "flat-top", "--overlap", "75"});
  EXPECT_NEAR(flat["enbw_hz"].get<double>() / flat["step_hz"].get<double>(), 3.8112, 1e-3);
  EXPECT_GT(flat["averages"], density["averages"]);
  EXPECT_EQ(
      rb({"spectrum", record_, "--channel", "driver_knuckle_z", "--block", "256", "--segment-s", "2"}).code,
      2);
}

TEST_F(RecordingCommands, ATransferredRecordingIsThatRecording) {
  ASSERT_EQ(import(kWobble, record_).code, 0);
  const std::string archive = record_ + " archive";
  const std::string copy = archive + "/" + std::filesystem::path(record_).filename().string();
  EXPECT_NE(rb({"transfer", record_, "--to", archive}).log.find(archive + ": there is no such folder"),
            std::string::npos);
  std::filesystem::create_directories(archive);
  const test::Outcome first = rb({"transfer", record_, "--to", archive, "--json"});
  ASSERT_EQ(first.code, 0) << first.log;
  const Json told = Json::parse(first.output)["transferred"][0];
  EXPECT_EQ(told["to"], copy);
  EXPECT_FALSE(told["was_there"]);
  EXPECT_EQ(rb({"verify", copy}).code, 0);
  EXPECT_EQ(rb({"levels", copy}).output, rb({"levels", record_}).output);
  EXPECT_EQ(std::system(("cd '" + copy + "' && sha256sum --quiet --strict -c sha256.txt").c_str()), 0);

  EXPECT_TRUE(Json::parse(
      rb({"transfer", record_, "--to", archive, "--json"}).output)["transferred"][0]["was_there"]);

  const test::Outcome none = rb({"transfer", archive, "--to", record_});
  EXPECT_EQ(none.code, 4);
  EXPECT_NE(none.log.find(archive + ": no recording"), std::string::npos) << none.log;
}

TEST_F(RecordingCommands, ResponseTellsHowTwoChannelsGoTogether) {
  ASSERT_EQ(import(kWobble, record_).code, 0);
  const auto transfer = [&](const std::string& input, const std::string& output) {
    const test::Outcome told = rb({"response", record_, "--input", input, "--output", output, "--json"});
    EXPECT_EQ(told.code, 0) << told.log;
    return Json::parse(told.output);
  };
  const std::string driver = "driver_knuckle_z", passenger = "passenger_knuckle_z";
  const Json there = transfer(driver, passenger), back = transfer(passenger, driver),
             itself = transfer(driver, driver);
  EXPECT_GE(there["averages"], 3);
  ASSERT_EQ(there["bins"].size(), back["bins"].size());
  double largest = 0.0;
  for (std::size_t k = 1; k < there["bins"].size(); ++k) {
    const auto h = [&](const Json& of) {
      return std::complex<double>(of["bins"][k]["h1"][0], of["bins"][k]["h1"][1]);
    };
    const double coherence = there["bins"][k]["coherence"];
    largest = std::max(largest, coherence);
    // G_xy / G_xx times G_yx / G_yy is the coherence.
    EXPECT_LT(std::abs(h(there) * h(back) - coherence), 1e-12) << k;
    EXPECT_LT(std::abs(h(itself) - 1.0), 1e-12) << k;
    EXPECT_NEAR(itself["bins"][k]["coherence"].get<double>(), 1.0, 1e-12);
  }
  EXPECT_GT(largest, there["coherence_by_chance"]) << "two knuckles of one car";
  const test::Outcome text = rb({"response", record_, "--input", driver, "--output", passenger});
  EXPECT_NE(text.output.find("# passenger_knuckle_z / driver_knuckle_z"), std::string::npos) << text.output;
  const test::Outcome unknown = rb({"response", record_, "--input", driver, "--output", "bonnet_z"});
  EXPECT_EQ(unknown.code, 2);
  EXPECT_NE(unknown.log.find("--output bonnet_z"), std::string::npos) << unknown.log;
  const test::Outcome too_long =
      rb({"response", record_, "--input", driver, "--output", passenger, "--segment-s", "900"});
  EXPECT_EQ(too_long.code, 1);
  EXPECT_NE(too_long.log.find("no stretch without a hole is as long as a segment"), std::string::npos);
}

TEST_F(RecordingCommands, DamageCostsWhatItHitAndIsSaid) {
  ASSERT_EQ(import(kWobble, record_).code, 0);
  const Json whole = Json::parse(rb({"levels", record_, "--json"}).output);
  const std::string segment = record_ + "/seg-000001.lcm";
  // In the samples of a block.
  std::ifstream written(segment, std::ios::binary);
  const std::string bytes((std::istreambuf_iterator<char>(written)), {});
  const auto middle = static_cast<std::streamoff>(bytes.find("_SCAN", bytes.size() / 2) + 200);
  std::fstream file(segment, std::ios::in | std::ios::out | std::ios::binary);
  file.seekg(middle);
  const char flipped = static_cast<char>(file.get() ^ 1);
  file.seekp(middle);
  file.put(flipped);
  file.close();

  EXPECT_EQ(rb({"verify", record_}).code, 1);
  const test::Outcome levels = rb({"levels", record_, "--json"});
  EXPECT_EQ(levels.code, 0) << levels.log;
  EXPECT_NE(levels.log.find("damaged"), std::string::npos) << levels.log;
  // One event is lost, a block of 20 scans at the most.
  const double rate_hz = 117.0;
  const double lost_s = whole["channels"][0]["seconds"].get<double>() -
                        Json::parse(levels.output)["channels"][0]["seconds"].get<double>();
  EXPECT_GE(lost_s, 0.0);
  EXPECT_LT(lost_s, 21 / rate_hz);
}

TEST_F(RecordingCommands, NameWhatIsAtFault) {
  ASSERT_EQ(import(kWobble, record_).code, 0);
  const test::Outcome again = import(kWobble, record_);
  EXPECT_EQ(again.code, 4) << again.log;
  EXPECT_NE(again.log.find(record_), std::string::npos) << "a recording is never overwritten: " << again.log;

  const test::Outcome channel = rb({"spectrum", record_, "--channel", "bonnet_z"});
  EXPECT_EQ(channel.code, 2);
  EXPECT_NE(channel.log.find("bonnet_z"), std::string::npos);
  EXPECT_NE(channel.log.find("driver_knuckle_z"), std::string::npos) << "and what there is";

  for (const char* command : {"verify", "levels", "identify"}) {
    const test::Outcome nowhere = rb({command, folder_ / "nowhere"});
    EXPECT_EQ(nowhere.code, 4) << command << ": " << nowhere.log;
    EXPECT_NE(nowhere.log.find("nowhere"), std::string::npos) << nowhere.log;
    EXPECT_NE(nowhere.log.find("No such file or directory"), std::string::npos) << nowhere.log;
    EXPECT_NE(rb({command, kWobble}).log.find("Not a directory"), std::string::npos) << command;
  }
  EXPECT_EQ(import(folder_ / "none.csv", folder_ / "other").code, 4);
}

}  // namespace
}  // namespace roadbalance
