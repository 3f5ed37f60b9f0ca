#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <regex>
#include <sstream>

#include "common/test/source.hpp"

namespace roadbalance {
namespace {

std::string text_of(const std::filesystem::path& file) {
  std::ostringstream text;
  text << std::ifstream(file).rdbuf();
  return text.str();
}

// The node must be unable to disturb the car's bus: of all its files one opens CAN sockets, and that one
// calls nothing that sends.
TEST(Socketcan, HasNoTransmitPath) {
  const std::regex opens("\\b(PF_CAN|AF_CAN|CAN_RAW)\\b");
  const std::regex sends(
      "\\b(send|sendto|sendmsg|sendmmsg|write|writev|pwrite|sendfile|splice|io_uring\\w*|aio_\\w+)\\s*\\(");
  std::vector<std::string> openers;
  for (const char* room : {"firmware", "common"})
    for (const auto& entry : std::filesystem::recursive_directory_iterator(test::source_path(room))) {
      const std::string name = entry.path().filename().string();
      const std::string kind = entry.path().extension().string();
      if ((kind != ".cpp" && kind != ".hpp") || entry.path().string().find("/test/") != std::string::npos)
        continue;
      if (!std::regex_search(text_of(entry.path()), opens)) continue;
      openers.push_back(name);
      EXPECT_FALSE(std::regex_search(text_of(entry.path()), sends)) << entry.path() << " can send";
    }
  EXPECT_EQ(openers, std::vector<std::string>{"can_socket.cpp"});
}

}  // namespace
}  // namespace roadbalance
