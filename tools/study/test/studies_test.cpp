#include <gtest/gtest.h>

#include <algorithm>
#include <set>
#include <string>

#include "common/config/section.hpp"
#include "tools/study/study.hpp"

namespace roadbalance {
namespace {

using Json = nlohmann::ordered_json;

TEST(Studies, HaveNamesOfTheirOwnAndALineEach) {
  std::set<std::string> names;
  for (const Study& study : studies()) {
    EXPECT_TRUE(names.insert(study.name).second) << study.name;
    EXPECT_FALSE(study.line.empty()) << study.name;
    EXPECT_EQ(study.line.find('\n'), std::string::npos);
    EXPECT_EQ(&study_of(study.name), &study);
  }
  for (const char* name : {"demo-accuracy", "drift", "clock-skew", "encoder"})
    EXPECT_TRUE(names.contains(name));
}

TEST(Studies, NameOneAnotherWhereThereIsNone) {
  try {
    study_of("fig4711");
    FAIL();
  } catch (const ConfigError& error) {
    EXPECT_NE(std::string(error.what()).find("demo-accuracy"), std::string::npos);
  }
}

TEST(Settings, ChangeInTheirKind) {
  Json settings{{"samples", {1, 2}}, {"roughness", 16e-6}, {"names", ""}, {"runs", 3}};
  change_setting(settings, "samples=500,600,700");
  change_setting(settings, "roughness=1");
  change_setting(settings, "names=a,b=c");
  EXPECT_EQ(settings,
            Json({{"samples", {500, 600, 700}}, {"roughness", 1.0}, {"names", "a,b=c"}, {"runs", 3}}));
}

TEST(Settings, RefuseWhatIsNotOfTheirKind) {
  Json settings{{"samples", {1, 2}}, {"roughness", 16e-6}};
  for (const char* change :
       {"samples=x", "samples=1.5", "samples=", "roughness=high", "other=1", "roughness"})
    EXPECT_THROW(change_setting(settings, change), ConfigError) << change;
}

TEST(Settings, RefuseWhatCannotBeStudied) {
  Json settings = study_of("fig3").settings;
  for (const char* change :
       {"samples=-5", "samples=0", "samples=5000,16", "rear_coherence2=1", "rear_coherence2=2",
        "rear_coherence2=-0.1", "road_gd_m3=0", "road_gd_m3=-1", "estimators=none-such"})
    EXPECT_THROW(change_setting(settings, change), ConfigError) << change;
  EXPECT_EQ(settings, study_of("fig3").settings);
  try {
    change_setting(settings, "rear_coherence2=1");
  } catch (const ConfigError& error) {
    EXPECT_STREQ(error.what(), "--set rear_coherence2=1: allowed: 0.0 .. 0.9999");
  }
  settings = study_of("coverage").settings;
  for (const char* change : {"road=Q", "road=", "seconds=0", "seconds=-20"})
    EXPECT_THROW(change_setting(settings, change), ConfigError) << change;
  settings = study_of("radial-force").settings;
  EXPECT_THROW(change_setting(settings, "force_n=-1"), ConfigError);
}

TEST(Settings, AreWhatTheyMayBeUnlessSaid) {
  for (const Study& study : studies())
    for (const auto& [key, value] : study.settings.items()) {
      std::string text = value.is_string() ? value.get<std::string>() : value.dump();
      if (value.is_array()) text = text.substr(1, text.size() - 2);
      Json settings = study.settings;
      EXPECT_NO_THROW(change_setting(settings, key + "=" + text)) << study.name;
      EXPECT_EQ(settings, study.settings);
    }
}

TEST(Tables, SayTheSameOnATerminalAndInMarkdown) {
  const Json summary{
      {"tables",
       {{{"title", "Errors"},
         {"rows", {{{"wheel", "left"}, {"error", 0.12345}}, {{"wheel", "right"}, {"error", nullptr}}}}}}},
      {"acceptance",
       {{{"line", "all"}, {"value", 0.5}, {"required", {0.0, 1.0}}, {"answers", 12}, {"met", true}}}}};
  EXPECT_EQ(plain_tables(summary), "Errors\nwheel  error  \nleft   0.123  \nright      -  \n\n");
  EXPECT_EQ(markdown_tables(summary),
            "**Errors**\n\n| wheel | error |\n| --- | ---: |\n| left | 0.123 |\n| right | - |\n\n"
            "| acceptance | value | required | answers | |\n| --- | ---: | ---: | ---: | --- |\n"
            "| all | 0.5 | 0 .. 1 | 12 | met |\n");
}

TEST(Tables, TellEachLineOfAcceptanceInFullNumbers) {
  const Json summary{{"acceptance",
                      {{{"line", "small"},
                        {"value", 1.2345678e-05},
                        {"standard_error", 0.000123456},
                        {"required", {0.0, 0.1}},
                        {"answers", 40},
                        {"met", true}},
                       {{"line", "none"}, {"value", nullptr}, {"required", {0.0, 1.0}}, {"met", false}},
                       {{"line", "few"}, {"value", 100.0}, {"required", {0, 100}}, {"met", nullptr}}}}};
  const std::string text = plain_acceptance(summary);
  EXPECT_TRUE(text.starts_with("met         small")) << text;
  EXPECT_NE(text.find(" 1.23e-05 +- 0.000123  (0 .. 0.1)  n = 40\n"), std::string::npos) << text;
  EXPECT_NE(text.find("\nNOT MET     none"), std::string::npos) << text;
  EXPECT_NE(text.find("\nnot judged  few"), std::string::npos) << text;
  EXPECT_NE(markdown_tables(summary).find("| few | 100 | 0 .. 100 |  | not judged |\n"), std::string::npos);
  EXPECT_EQ(plain_acceptance({{"tables", Json::array()}}), "");
  EXPECT_EQ(plain_acceptance({{"acceptance", Json::array()}}), "NOT MET     nothing was judged\n");
}

/// A study does what it accepts on the command line: a folder asked for is not left empty.
TEST(Studies, ThatTakeSvgDrawFigures) {
  std::set<std::string> drawing;
  for (const Study& study : studies())
    if (std::ranges::count(study.options, "--svg") > 0) drawing.insert(study.name);
  for (const char* name :
       {"fig3", "fig4", "influences", "estimators", "cancellation", "parameters", "drift", "quantisation",
        "radial-force", "coverage", "end-to-end", "demo-accuracy", "equations", "many-drives"})
    EXPECT_TRUE(drawing.contains(name)) << name;
  EXPECT_EQ(drawing.size(), 14u);
}

}  // namespace
}  // namespace roadbalance
