// One short run of every study that is repeated over seeds, from the drive to the table.
#include <gtest/gtest.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <string>

#include "tools/study/study.hpp"

namespace roadbalance {
namespace {

using Json = nlohmann::ordered_json;

/// Values that cannot be determined: wheels in step in so short a drive; those that an estimator does not
/// estimate.
bool untold(const Json& row, const std::string& column) {
  const std::string name = row.value("case", ""), estimator = row["estimator"];
  return name == "0.95, wheels in step" || name == "radii +- 0 %" || estimator == "chassis" ||
         (estimator == "correlation" && column.starts_with("ct"));
}

class ShortStudies : public testing::TestWithParam<std::string> {};

TEST_P(ShortStudies, RunAndSayWhatCameOut) {
  const Study& study = study_of(GetParam());
  Json settings = study.settings;
  if (settings.contains("samples")) change_setting(settings, "samples=5000");
  if (settings.contains("seconds")) change_setting(settings, "seconds=20");
  if (settings.contains("drives")) change_setting(settings, "drives=8");
  if (settings.contains("only")) change_setting(settings, "only=friction");
  std::string name = (std::filesystem::temp_directory_path() / "study-XXXXXX").string();
  ASSERT_NE(mkdtemp(name.data()), nullptr);
  const std::filesystem::path folder = name;
  const std::vector<Json> runs{study.run({1, settings, folder})};
  // A run's result goes through a file: as text it must be the same.
  EXPECT_EQ(Json::parse(runs[0].dump()), runs[0]);
  if (study.name == "fig3") {  // shortest of all
    EXPECT_EQ(study.run({1, settings, folder}), runs[0]) << "a run is a function of its seed";
    EXPECT_NE(study.run({2, settings, folder}), runs[0]);
  }
  const StudyResult result = study.summarise(settings, runs);
  EXPECT_EQ(result.summary["runs"], 1);
  for (const Json& table : result.summary["tables"]) {
    EXPECT_FALSE(table["rows"].empty());
    // One run has no deviation, and so no efficiency; sizes of errors it has.
    for (const Json& row : table["rows"])
      for (const auto& [column, value] : row.items())
        if (row.contains("estimator") && !untold(row, column) &&
            (column.find("median") != std::string::npos || column.find("rms") != std::string::npos)) {
          EXPECT_TRUE(value.is_number()) << column << " of " << row;
        }
  }
  EXPECT_FALSE(markdown_tables(result.summary).empty());
  std::filesystem::remove_all(folder);
}

INSTANTIATE_TEST_SUITE_P(All, ShortStudies,
                         testing::Values("fig3", "influences", "estimators", "cancellation", "quantisation",
                                         "equations", "radial-force", "coverage", "many-drives", "hazards",
                                         "real-road"),
                         [](const auto& parameter) {
                           std::string name = parameter.param;
                           for (char& c : name)
                             if (c == '-') c = '_';
                           return name;
                         });

}  // namespace
}  // namespace roadbalance
