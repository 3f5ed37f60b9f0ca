#include "tools/study/figure.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <cstdlib>
#include <fstream>
#include <regex>
#include <string>

namespace roadbalance {
namespace {

Figure example() {
  return {"example",
          "Errors & <more>",
          {"samples", true},
          {"error \"%\"", true},
          {{"falls", {1e3, 1e4, 1e5}, {10.0, 1.0, 0.1}}, {"bound", {1e3, 1e5}, {5.0, 0.5}, true, false}}};
}

/// Places of all markers, in the order in which they are drawn.
std::vector<std::pair<double, double>> markers(const std::string& text) {
  std::vector<std::pair<double, double>> places;
  const std::regex circle("cx=\"([^\"]+)\" cy=\"([^\"]+)\"");
  for (std::sregex_iterator i(text.begin(), text.end(), circle), end; i != end; ++i)
    places.emplace_back(std::stod((*i)[1]), std::stod((*i)[2]));
  return places;
}

TEST(Svg, PutsPowersOfTenAtEqualDistancesOnLogarithmicAxes) {
  const auto places = markers(svg(example()));
  ASSERT_EQ(places.size(), 3u);
  EXPECT_NEAR(places[1].first - places[0].first, places[2].first - places[1].first, 0.01);
  EXPECT_NEAR(places[1].second - places[0].second, places[2].second - places[1].second, 0.01);
  EXPECT_GT(places[1].first, places[0].first);
  EXPECT_GT(places[1].second, places[0].second) << "a smaller value is further down";
}

TEST(Svg, PutsEqualStepsAtEqualDistancesOnLinearAxes) {
  Figure figure{"f", "t", {"x"}, {"y"}, {{"s", {-1.0, 0.0, 1.0}, {2.0, 4.0, 6.0}}}};
  const auto places = markers(svg(figure));
  ASSERT_EQ(places.size(), 3u);
  EXPECT_NEAR(places[1].first - places[0].first, places[2].first - places[1].first, 0.01);
  EXPECT_NEAR(places[0].second - places[1].second, places[1].second - places[2].second, 0.01);
}

TEST(Svg, InterruptsALineWhereThereIsNoValue) {
  Figure figure = example();
  figure.series = {{"s", {1, 2, 3, 4, 5}, {1.0, 2.0, std::nan(""), 0.0, 5.0}}};
  const std::string text = svg(figure);
  EXPECT_EQ(markers(text).size(), 3u);
  EXPECT_EQ(text.find("nan"), std::string::npos);
  EXPECT_EQ(text.find("inf"), std::string::npos);
}

TEST(Svg, OfNothingIsAnEmptyPlot) {
  const std::string text = svg({"f", "t", {"x", true}, {"y"}, {{"s", {}, {}}}});
  EXPECT_EQ(text.find("nan"), std::string::npos);
  EXPECT_NE(text.find("</svg>"), std::string::npos);
}

/// Another program's parser reads the file.
TEST(Svg, IsWellFormedAndComplete) {
  std::string name = (std::filesystem::temp_directory_path() / "figure-XXXXXX").string();
  ASSERT_NE(mkdtemp(name.data()), nullptr);
  const std::filesystem::path folder = name;
  write_figures({example()}, folder / "figures");
  const std::string program =
      "import sys, xml.etree.ElementTree as tree\n"
      "root = tree.parse(sys.argv[1]).getroot()\n"
      "names = ''.join(root.itertext())\n"
      "svg = '{http://www.w3.org/2000/svg}'\n"
      "assert root.tag == svg + 'svg' and root.attrib['viewBox']\n"
      "assert len(root.findall(svg + 'circle')) == 3\n"
      "assert 'Errors & <more>' in names and 'error \"%\"' in names and 'falls' in names\n"
      "assert 'prefers-color-scheme:dark' in root.find(svg + 'style').text\n"
      "assert 'href' not in open(sys.argv[1]).read()\n";
  std::ofstream(folder / "read.py") << program;
  const std::string command =
      "python3 " + (folder / "read.py").string() + " " + (folder / "figures" / "example.svg").string();
  EXPECT_EQ(std::system(command.c_str()), 0);
  std::filesystem::remove_all(folder);
}

TEST(Distribution, CountsWhatIsNotKnownAsLarger) {
  const Series series = distribution("errors", {-3.0, 1.0, std::nan(""), 2.0, HUGE_VAL});
  EXPECT_EQ(series.x, (std::vector<double>{1.0, 2.0, 3.0}));
  EXPECT_EQ(series.y, (std::vector<double>{20.0, 40.0, 60.0}));
  EXPECT_TRUE(distribution("none", {}).x.empty());
}

}  // namespace
}  // namespace roadbalance
