#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <set>

#include "common/bus/notes.hpp"
#include "host/recording/formats/uff58_reader.hpp"
#include "tools/import/test/import_fixture.hpp"

// No unit is taken for another: the right value, or a refusal that names channel and remedy.
namespace roadbalance {
namespace {

/// Universal files as SDRC describes them, written here by the columns of that description.
class ImportUnits : public ImportSamples {
 protected:
  static constexpr int kRows = 600;
  static double stored(int row) { return 0.5 + 0.25 * (row % 4); }

  /// Data set 58 of a channel: record 9 with a type and a unit's label.
  static std::string function(const std::string& name, int type, const std::string& unit,
                              const std::string& axis = "Acceleration") {
    std::string text = "    -1\n    58\n" + name + "\nNONE\nNONE\nNONE\nNONE\n";
    text += "    1         1    0         0 NONE               1   3 NONE               0   0\n";
    text += line("%10d%10d%10d%13.5E%13.5E%13.5E\n", 4, kRows, 1, 0.0, 1.0 / kRate_hz, 0.0);
    text += line("%10d%5d%5d%5d %-20s %-20s\n", 17, 0, 0, 0, "Time", "s");
    text += line("%10d%5d%5d%5d %-20s %-20s\n", type, 1, 0, 0, axis.c_str(), unit.c_str());
    text += line("%10d%5d%5d%5d %-20s %-20s\n", 0, 0, 0, 0, "NONE", "NONE");
    text += line("%10d%5d%5d%5d %-20s %-20s\n", 0, 0, 0, 0, "NONE", "NONE");
    for (int row = 0; row < kRows; ++row) text += line("%20.12E%s", stored(row), row % 4 == 3 ? "\n" : "");
    return text + "    -1\n";
  }
  /// Data set 164: units of length in a metre.
  static std::string lengths(int code, double in_a_metre) {
    return line("    -1\n   164\n%10d%-20s%10d\n%25.17E%25.17E%25.17E\n%25.17E\n    -1\n", code, "units", 2,
                in_a_metre, 1.0, 1.0, 273.15);
  }
  template <typename... Values>
  static std::string line(const char* pattern, Values... values) {
    std::string text(256, '\0');
    text.resize(static_cast<std::size_t>(std::snprintf(text.data(), text.size(), pattern, values...)));
    return text;
  }

  /// m/s^2 for each unit of the file's numbers, by the record that import makes; or the refusal.
  struct Result {
    double factor = 0.0;
    std::string said, refused, in_file, second_said;
  };
  Result import(const std::string& head, int type, const std::string& unit, const UnitOptions& options = {}) {
    return import_file(head + function("first_up", type, unit) + function("second_up", 12, "m/s^2"), options);
  }
  Result import_file(const std::string& text, const UnitOptions& options = {}) {
    const auto car = two_nodes();
    fs::remove_all(folder_ / "record");
    Result result;
    try {
      const ImportReport report = import_samples({.samples = write("drive.uff", text),
                                                  .folder = folder_ / "record",
                                                  .open = open_uff58_samples,
                                                  .units = options},
                                                 car);
      result.said = report.channels.at(0).meaning;
      result.in_file = report.channels.at(0).in_file;
      result.second_said = report.channels.at(1).meaning;
    } catch (const ConfigError& error) {
      result.refused = error.what();
      return result;
    }
    std::set<double> factors;
    int row = 0;
    for (const SealedBlock& block : blocks_of_record()) {
      if (block.kind != BlockKind::kScan || block.header.node != 1) continue;
      const auto scan = decode_scan(block);
      for (std::int64_t k = 0; k < block.header.scans; ++k, ++row)
        factors.insert(car.node[0].channel[0].to_si(scan.counts[static_cast<std::size_t>(k)][0]) /
                       stored(row));
    }
    EXPECT_EQ(row, kRows);
    result.factor = *factors.begin();
    // Half a count of 50 m/s^2 at full scale is 3 um/s^2.
    EXPECT_LT(*factors.rbegin() - *factors.begin(), 2e-5);
    return result;
  }
};

TEST_F(ImportUnits, AccelerationsComeInTheUnitTheirFileGives) {
  // Factors by definition: 1 in = 25.4 mm, 1 ft = 304.8 mm, 1 g = 9.80665 m/s^2.
  const std::map<std::string, double> kLabels{
      {"m/s^2", 1.0},     {"m/s2", 1.0},      {"m/s\xC2\xB2", 1.0}, {"m/s\xB2", 1.0},  {"m/sec^2", 1.0},
      {"M/S**2", 1.0},    {"g", 9.80665},     {"G", 9.80665},       {"mm/s^2", 0.001}, {"cm/s^2", 0.01},
      {"in/s^2", 0.0254}, {"ft/s^2", 0.3048}, {"m/s/s", 1.0},       {"mg", 0.00980665}};
  for (const auto& [label, factor] : kLabels) {
    const Result result = import("", 12, label);
    EXPECT_EQ(result.refused, "");
    EXPECT_NEAR(result.factor, factor, 1e-5) << label;
  }
  EXPECT_NEAR(import("", 0, "g").factor, 9.80665, 1e-5) << "a kind that is unknown, with a unit";
  EXPECT_NEAR(import(lengths(1, 1.0), 12, "g").factor, 9.80665, 1e-5) << "the label counts more than the set";
}

TEST_F(ImportUnits, WithoutALabelTheFilesLengthsCount) {
  EXPECT_NEAR(import(lengths(1, 1.0), 12, "NONE").factor, 1.0, 1e-5);
  EXPECT_NEAR(import(lengths(5, 1000.0), 12, "NONE").factor, 0.001, 1e-5);
  EXPECT_NEAR(import(lengths(6, 100.0), 12, "").factor, 0.01, 1e-5);
  EXPECT_NEAR(import(lengths(7, 39.37008), 12, "").factor, 0.0254, 1e-5);
  EXPECT_NEAR(import(lengths(2, 3.28084), 12, "").factor, 0.3048, 1e-5);
  EXPECT_NE(import(lengths(9, 2.0), 12, "").refused.find("channel first_up: its unit is \"length/2/s^2\""),
            std::string::npos);
}

TEST_F(ImportUnits, WithoutAnyUnitSiIsAssumedAndSaid) {
  // Unknown, general, acceleration: none of them names a unit.
  for (const int type : {0, 1, 12}) {
    const Result result = import("", type, "NONE");
    EXPECT_NEAR(result.factor, 1.0, 1e-5);
    EXPECT_EQ(result.said, "m/s^2 is assumed, for the file has no unit") << type;
    EXPECT_EQ(result.in_file, "") << type;
    EXPECT_NEAR(import("", type, "", {.units = {"g"}}).factor, 9.80665, 1e-5) << type;
    EXPECT_NEAR(import("", type, "", {.sensitivity = {"500mV/g"}}).factor, 9.80665 / 0.5, 1e-5) << type;
  }
}

TEST_F(ImportUnits, AUnitAtTheEndOfTheAxisLabelCounts) {
  const auto of_axis = [&](const std::string& head, int type, const std::string& unit,
                           const std::string& axis) {
    return import_file(head + function("first_up", type, unit, axis) + function("second_up", 12, "m/s^2"));
  };
  for (const int type : {0, 12}) {
    EXPECT_NEAR(of_axis("", type, "NONE", "Acceleration g").factor, 9.80665, 1e-5) << type;
    EXPECT_NEAR(of_axis("", type, "", "Acc. (mm/s^2)").factor, 0.001, 1e-5) << type;
    EXPECT_NEAR(of_axis("", type, "", "Acc. [in / s^2]").factor, 0.0254, 1e-5) << type;
    EXPECT_NE(of_axis("", type, "", "Sensor V").refused.find("its unit is \"V\""), std::string::npos) << type;
    EXPECT_NE(of_axis("", type, "", "Upright X").said.find("is assumed"), std::string::npos) << type;
  }
  EXPECT_NEAR(of_axis(lengths(1, 1.0), 12, "NONE", "Acceleration g").factor, 9.80665, 1e-5)
      << "what is said of a channel counts more than what is said of the file";
  EXPECT_NEAR(of_axis("", 12, "mm/s^2", "Acceleration g").factor, 0.001, 1e-5)
      << "the field for the unit counts more than that for the axis";
}

TEST_F(ImportUnits, LengthsHoldForTheFunctionsThatFollowThem) {
  // By the definition of data set 164: a number divided by its length factor is in metres.
  const std::string mm = lengths(5, 1000.0), m = lengths(1, 1.0);
  const std::string first = function("first_up", 12, "NONE"), second = function("second_up", 12, "NONE");
  const Result both = import_file(mm + first + m + second);
  EXPECT_NEAR(both.factor, 0.001, 1e-5);
  EXPECT_EQ(both.said, "0.001 m/s^2 each");
  EXPECT_EQ(both.second_said, "1 m/s^2 each");
  const Result turned = import_file(m + first + mm + second);
  EXPECT_NEAR(turned.factor, 1.0, 1e-5);
  EXPECT_EQ(turned.second_said, "0.001 m/s^2 each");
}

TEST_F(ImportUnits, LengthsThatStandOnlyBehindAFunctionAreRefused) {
  const std::string text =
      function("first_up", 12, "NONE") + lengths(5, 1000.0) + function("second_up", 12, "NONE");
  const std::string refused = import_file(text).refused;
  EXPECT_NE(refused.find("channel first_up: its unit is \"of data set 164, which stands behind it\""),
            std::string::npos)
      << refused;
  EXPECT_NE(refused.find("--units first_up=g"), std::string::npos) << refused;
  EXPECT_NEAR(import_file(text, {.units = {"first_up=mm/s^2"}}).factor, 0.001, 1e-5);
}

TEST_F(ImportUnits, VoltsNeedASensitivity) {
  const std::string refused = import("", 12, "V").refused;
  EXPECT_NE(refused.find("drive.uff: channel first_up: its unit is \"V\""), std::string::npos) << refused;
  EXPECT_NE(refused.find("--sensitivity first_up=100mV/g"), std::string::npos) << refused;
  EXPECT_NEAR(import("", 1, "V", {.sensitivity = {"first_up=500mV/g"}}).factor, 9.80665 / 0.5, 1e-5);
  EXPECT_NEAR(import("", 12, "mV", {.sensitivity = {"first_up=10.2 mV/(m/s^2)"}}).factor, 1.0 / 10.2, 1e-5);
  EXPECT_NE(import("", 12, "g", {.sensitivity = {"first_up=100mV/g"}})
                .refused.find("--sensitivity: 100mV/g: channel first_up is in \"g\""),
            std::string::npos);
  EXPECT_NEAR(import("", 12, "g", {.sensitivity = {"100mV/g"}}).factor, 9.80665, 1e-5) << "of volts only";
  EXPECT_NEAR(import("", 12, "mV", {.sensitivity = {"500mV/g"}}).factor, 9.80665 / 500.0, 1e-5);
  EXPECT_NEAR(import("", 12, "EU", {.units = {"first_up=V"}, .sensitivity = {"500mV/g"}}).factor,
              9.80665 / 0.5, 1e-5);
  for (const char* wrong : {"100mV", "-1mV/g", "100g/mV", "mV/g", "nan mV/g", "100mV/m", "infV/g"})
    EXPECT_NE(import("", 12, "V", {.sensitivity = {std::string("first_up=") + wrong}})
                  .refused.find("--sensitivity: " + std::string(wrong)),
              std::string::npos)
        << wrong;
}

TEST_F(ImportUnits, WhatIsNoAccelerationIsRefusedWithItsRemedy) {
  for (const auto& [type, label, shown] : {std::tuple{8, "m", "m"},
                                           {8, "NONE", "m"},
                                           {11, "NONE", "m/s"},
                                           {11, "mm/s", "mm/s"},
                                           {13, "N", "N"},
                                           {13, "NONE", "data type 13"},
                                           {12, "EU", "EU"},
                                           {12, "m/s\xC2\xB3", "m/s\\xC2\\xB3"}}) {
    const std::string refused = import("", type, label).refused;
    EXPECT_NE(refused.find("drive.uff: channel first_up: its unit is \"" + std::string(shown) + '"'),
              std::string::npos)
        << refused;
    EXPECT_NE(refused.find("--units first_up=g"), std::string::npos) << refused;
  }
  const Result known = import("", 12, "EU", {.units = {"first_up=g"}});
  EXPECT_NEAR(known.factor, 9.80665, 1e-5);
  EXPECT_EQ(known.said, "9.80665 m/s^2 each, by --units g; the file says \"EU\"");
  EXPECT_NE(
      import("", 12, "g", {.units = {"third_up=g"}}).refused.find("--units: third_up=g: the file has no"),
      std::string::npos);
  EXPECT_NE(import("", 12, "g", {.units = {"m"}}).refused.find("--units: m: is no unit of channel first_up"),
            std::string::npos);
  EXPECT_NE(import("", 12, "g", {.units = {"g", "g"}}).refused.find("stands twice"), std::string::npos);
}

TEST_F(ImportUnits, AnAbscissaThatIsNoTimeInSecondsIsRefused) {
  std::string text = function("first_up", 12, "g") + function("second_up", 12, "g");
  for (auto at = text.find(" s  "); at != std::string::npos; at = text.find(" s  "))
    text.replace(at, 4, " ms ");
  EXPECT_THROW(open_uff58_samples(write("ms.uff", text)), ConfigError);
}

TEST_F(ImportUnits, CsvLikewise) {
  const auto text = [](const std::string& unit) {
    std::string rows = "time_s,first_up,second_up\ns," + unit + ",g\n";
    for (int row = 0; row < kRows; ++row) rows += line("%.6f,%.3f,0\n", row / kRate_hz, stored(row));
    return rows;
  };
  for (const auto& [unit, factor] : std::map<std::string, double>{{"m/s^2", 1.0},
                                                                  {"g", 9.80665},
                                                                  {"mm/s^2", 0.001},
                                                                  {"in/s^2", 0.0254},
                                                                  {"ft/s^2", 0.3048},
                                                                  {"", 1.0}}) {
    fs::remove_all(folder_ / "record");
    const auto report =
        import_samples({.samples = write("s.csv", text(unit)), .folder = folder_ / "record"}, two_nodes());
    EXPECT_NEAR(report.channels.at(0).factor, factor, 1e-12) << unit;
    EXPECT_EQ(report.channels.at(0).meaning.find("is assumed") != std::string::npos, unit.empty());
  }
  fs::remove_all(folder_ / "record");
  for (const char* unit : {"V", "m", "mm/s", "EU"})
    EXPECT_NE(error_of(text(unit), two_nodes()).find(std::string("channel first_up: its unit is \"") + unit),
              std::string::npos)
        << unit;
}

TEST_F(ImportUnits, TheRecordKeepsFileDigestAndUnits) {
  (void)import("", 12, "mm/s^2");
  std::vector<std::string> notes;
  RecordReader reader(folder_ / "record");
  while (const auto event = reader.next())
    if (const auto note = event->channel == "RB_NOTE" ? decode_note(event->data) : std::nullopt;
        note && note->kind == NoteKind::kImported)
      notes.push_back(note->text);
  ASSERT_EQ(notes.size(), 2U);
  std::FILE* const sum = ::popen(("sha256sum " + (folder_ / "drive.uff").string()).c_str(), "r");
  ASSERT_NE(sum, nullptr);
  std::string digest(64, '\0');
  EXPECT_EQ(std::fread(digest.data(), 1, digest.size(), sum), digest.size());
  ::pclose(sum);
  EXPECT_EQ(notes[0], "drive.uff, SHA-256 " + digest);
  EXPECT_EQ(notes[1], "first_up in \"mm/s^2\": 0.001 m/s^2 each; second_up in \"m/s^2\": 1 m/s^2 each");
}

}  // namespace
}  // namespace roadbalance
