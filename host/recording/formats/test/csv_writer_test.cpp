#include "host/recording/formats/csv_writer.hpp"

#include <gtest/gtest.h>

#include <fstream>
#include <iterator>
#include <string>

#include "common/test/temporary_directory.hpp"
#include "host/recording/formats/csv_text.hpp"

namespace roadbalance {
namespace {

// OWASP, CSV Injection: a spreadsheet computes what begins so, in quotes, too.  RFC 4180: quotes around
// commas.
TEST(CsvWriter, NoNameOfAChannelIsComputedOrEndsItsCell) {
  const test::TemporaryDirectory folder;
  ExportTable table;
  table.group.resize(1);
  for (const char* name : {"=cmd|x", "+49", "-5", "@home", "'=1", "=a,b", "say \"z\"", "fl_z"})
    table.group[0].channel.push_back({.name = name, .unit = "m/s^2"});
  make_csv_writer(folder / "drive.csv", table)->close();
  std::ifstream file(folder / "drive.csv");
  EXPECT_EQ(std::string(std::istreambuf_iterator<char>(file), {}),
            "time_s,'=cmd|x,'+49,'-5,'@home,''=1,\"'=a,b\",\"say \"\"z\"\"\",fl_z\n"
            "s,m/s^2,m/s^2,m/s^2,m/s^2,m/s^2,m/s^2,m/s^2,m/s^2\n");
}

TEST(CsvText, ANameComesBackFromItsCell) {
  for (const std::string name : {"=cmd|x", "'=1", "''@", "fl_z", "'twas"}) {
    const std::string cell = name_cell(name);
    EXPECT_EQ(unprotected_text(cell), name);
    EXPECT_EQ(std::string("=+-@").find(cell.front()), std::string::npos) << cell;
  }
}

}  // namespace
}  // namespace roadbalance
