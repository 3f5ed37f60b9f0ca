#include "common/command_line/manual.hpp"

#include <gtest/gtest.h>

#include <CLI/CLI.hpp>
#include <cstdio>
#include <fstream>
#include <set>
#include <sstream>

#include "common/command_line/run_program.hpp"
#include "common/test/temporary_directory.hpp"

namespace roadbalance {
namespace {

class Manual : public testing::Test {
 protected:
  Manual() {
    app_.require_subcommand(1);
    app_.footer("Exit codes: 0 done, 2 usage.\n.hidden request?\n\nThe car is simulated.");
    CLI::App* take = app_.add_subcommand("take", "Takes what is \"there\" - or C:\\not");
    take->add_option("folder", folder_, "the recording")->required();
    take->add_option("-o,--output", output_, "file to make")->required();
    take->add_option("--from", from_, "begin, s")->capture_default_str();
    take->add_flag("--json", json_, "one JSON object");
    take->add_option("--secret", folder_, "not for everybody")->group("");
    CLI::App* set = app_.add_subcommand("set", "Sets things");
    set->add_subcommand("filter", "Sets the filter")->add_option("names", names_, "of channels");
    set->add_subcommand("range", "Sets the range");
    list_program(app_, "study", "Studies many cars")->group("Develop");
    add_manual(app_);
  }

  /// Exit code of the program when it is called so.
  int call(const std::vector<std::string>& words) {
    try {
      app_.parse(std::vector<std::string>(words.rbegin(), words.rend()));
    } catch (const CLI::ParseError& error) {
      return app_.exit(error, printed_, printed_);
    }
    return -1;
  }
  void write() { ASSERT_EQ(call({"--write-manual", folder_of_pages()}), 0) << printed_.str(); }
  std::string folder_of_pages() const { return directory_.path() / "manual"; }

  static std::string output_of(const std::string& command) {
    std::string text;
    FILE* pipe = popen(("LC_ALL=C.UTF-8 " + command + " 2>&1").c_str(), "r");
    for (int c; (c = std::fgetc(pipe)) != EOF;) text += static_cast<char>(c);
    EXPECT_EQ(pclose(pipe), 0) << command << "\n" << text;
    return text;
  }
  /// The page as a reader of man(1) sees it on 100 columns; groff's warnings would stand in it.
  std::string read(const std::string& page) const {
    const std::string path = folder_of_pages() + "/" + page + ".1";
    EXPECT_EQ(output_of("groff -man -Tutf8 -ww -z " + path), "") << "groff warns";
    return output_of("groff -man -Tutf8 -P-cbou -rLL=100n " + path);
  }
  /// The words that bash offers after these, the last of which is begun.
  std::set<std::string> offered(const std::string& words, int number,
                                const std::string& first = "true") const {
    std::istringstream lines(output_of("bash --norc -c '" + first + "; source " + folder_of_pages() +
                                       "/car.bash; cd " + directory_.path().string() + "; COMP_WORDS=(" +
                                       words + "); COMP_CWORD=" + std::to_string(number) +
                                       "; _car; printf \"%s\\n\" \"${COMPREPLY[@]}\"'"));
    std::set<std::string> all;
    for (std::string line; std::getline(lines, line);) all.insert(line);
    return all;
  }

  test::TemporaryDirectory directory_;
  CLI::App app_{"Does what cars need.", "car"};
  std::string folder_, output_;
  std::vector<std::string> names_;
  double from_ = 1.5;
  bool json_ = false;
  std::ostringstream printed_;
};

TEST_F(Manual, HasAPageForEachCommandAndNoMore) {
  write();
  std::set<std::string> names;
  for (const auto& entry : std::filesystem::directory_iterator(folder_of_pages()))
    names.insert(entry.path().filename());
  EXPECT_EQ(names, (std::set<std::string>{"car.1", "car-take.1", "car-set.1", "car-set-filter.1",
                                          "car-set-range.1", "car.bash"}));
}

TEST_F(Manual, SaysWhatHelpSays) {
  write();
  const std::string page = read("car-take");
  for (const char* part :
       {"car-take - Takes what is \"there\" - or C:\\not", "car take --output TEXT [options] folder",
        "ARGUMENTS", "the recording", "file to make", "--from FLOAT", "begin, s; default: 1.5", "--json",
        "EXIT STATUS", "0 done, 2 usage.", ".hidden request?", "NOTES", "The car is simulated.", "car(1)"})
    EXPECT_NE(page.find(part), std::string::npos) << part << " is not in\n" << page;
  EXPECT_EQ(page.find("secret"), std::string::npos);
  EXPECT_NE(read("car-set").find("car-set-filter(1)"), std::string::npos);
  EXPECT_NE(read("car-set-filter").find("car set filter [options] [names ...]"), std::string::npos);
}

TEST_F(Manual, BashCompletesCommandsAndOptions) {
  write();
  using Words = std::set<std::string>;
  EXPECT_EQ(offered("car ''", 1), (Words{"set", "study", "take"}));
  EXPECT_EQ(offered("car set f", 2), Words{"filter"});
  EXPECT_EQ(offered("car take --", 2), (Words{"--help", "--output", "--from", "--json"}));
  EXPECT_EQ(offered("car take --from 2 --j", 4), Words{"--json"});
}

TEST_F(Manual, ListsAProgramInItsGroupAndLeavesTheRestToIt) {
  write();
  const std::string page = read("car");
  const std::size_t group = page.find("Develop");
  ASSERT_NE(group, std::string::npos) << page;
  EXPECT_GT(page.find("car-study(1)"), group) << page;
  EXPECT_LT(page.find("car-take(1)"), group) << page;
  using Words = std::set<std::string>;
  EXPECT_EQ(offered("car study --runs fo", 3, "_car_study() { COMPREPLY=($COMP_CWORD ${COMP_WORDS[@]}); }"),
            (Words{"2", "car-study", "--runs", "fo"}));
  EXPECT_EQ(offered("car study --", 2), Words{""}) << "its completion is not there";
}

TEST_F(Manual, BashCompletesFilesForValuesAndArguments) {
  write();
  std::ofstream(directory_.path() / "drive one") << "";
  EXPECT_EQ(offered("car take dri", 2), std::set<std::string>{"drive one"});
  EXPECT_EQ(offered("car take -o dri", 3), std::set<std::string>{"drive one"});
  EXPECT_EQ(offered("car take -o set dri", 4), std::set<std::string>{"drive one"});
}

TEST_F(Manual, NamesTheFileThatCannotBeWritten) {
  std::filesystem::create_directories(folder_of_pages() + "/car-set.1");
  EXPECT_NE(call({"--write-manual", folder_of_pages()}), 0);
  EXPECT_NE(printed_.str().find("car-set.1: Is a directory"), std::string::npos) << printed_.str();
}

}  // namespace
}  // namespace roadbalance
